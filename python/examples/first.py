"""A ruby built in code, rendered into an array and a picture: first.py RUBY.png"""

import sys

import gemtrace

scene = gemtrace.Scene(
    camera={"position": (3.0, -11.0, 28.0), "look_at": (0.0, 0.0, 0.0)},
    stones=[{"shape": "round-brilliant", "width": 6.5, "material": "ruby"}],
    film={"width": 96, "height": 96},
)
film = scene.render(quality="draft")
red, green, blue = film.rgb()[48, 48]
print(film, film.save(sys.argv[1]))
assert red > green and red > blue, "a ruby is red"
