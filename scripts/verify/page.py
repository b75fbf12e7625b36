"""docs/verification.md from the figures."""


def write(result):
    """The whole page."""
    return ""
