// The colour difference CIEDE2000 of two pictures as they are on the screen.

const DEG = Math.PI / 180;

const linear = Float64Array.from({ length: 256 }, (_, i) => {
  const v = i / 255;
  return v <= 0.04045 ? v / 12.92 : ((v + 0.055) / 1.055) ** 2.4;
});

/** CIELAB under D65 of three sRGB bytes. */
export function lab(r, g, b) {
  const [R, G, B] = [linear[r], linear[g], linear[b]];
  const f = t => (t > 216 / 24389 ? Math.cbrt(t) : (24389 / 27 * t + 16) / 116);
  const x = f((0.4123908 * R + 0.3575843 * G + 0.1804808 * B) / 0.9504559);
  const y = f(0.2126390 * R + 0.7151687 * G + 0.0721923 * B);
  const z = f((0.0193308 * R + 0.1191948 * G + 0.9505322 * B) / 1.0890578);
  return [116 * y - 16, 500 * (x - y), 200 * (y - z)];
}

/** CIEDE2000 of two CIELAB colours (Sharma, Wu and Dalal 2005). */
export function deltaE([L1, a1, b1], [L2, a2, b2]) {
  const c = (Math.hypot(a1, b1) + Math.hypot(a2, b2)) / 2, g = 0.5 * (1 - Math.sqrt(c ** 7 / (c ** 7 + 25 ** 7)));
  const A1 = a1 * (1 + g), A2 = a2 * (1 + g), C1 = Math.hypot(A1, b1), C2 = Math.hypot(A2, b2);
  const hue = (b, a) => (a || b ? (Math.atan2(b, a) / DEG + 360) % 360 : 0);
  const h1 = hue(b1, A1), h2 = hue(b2, A2), grey = !C1 || !C2;
  let dh = h2 - h1, h = h1 + h2;
  if (Math.abs(h1 - h2) > 180) { dh += dh > 0 ? -360 : 360; h += h < 360 ? 360 : -360; }
  if (grey) dh = 0; else h /= 2;
  const L = (L1 + L2) / 2, C = (C1 + C2) / 2, cos = angle => Math.cos(angle * DEG);
  const T = 1 - 0.17 * cos(h - 30) + 0.24 * cos(2 * h) + 0.32 * cos(3 * h + 6) - 0.2 * cos(4 * h - 63);
  const l = (L2 - L1) / (1 + 0.015 * (L - 50) ** 2 / Math.sqrt(20 + (L - 50) ** 2));
  const k = (C2 - C1) / (1 + 0.045 * C), H = 2 * Math.sqrt(C1 * C2) * Math.sin(dh / 2 * DEG) / (1 + 0.015 * C * T);
  const rt = -2 * Math.sqrt(C ** 7 / (C ** 7 + 25 ** 7)) * Math.sin(60 * DEG * Math.exp(-(((h - 275) / 25) ** 2)));
  return Math.sqrt(l * l + k * k + H * H + rt * k * H);
}

/** The mean over the pixels that differ from the ground in either picture: over the stones. Every `step`th pixel is taken. */
export function difference(a, b, step = 7) {
  if (a.width !== b.width || a.height !== b.height) return null;
  const [p, q] = [a, b].map(c => c.getContext('2d').getImageData(0, 0, c.width, c.height).data);
  const ground = [p[0], p[1], p[2]];
  const bare = (d, i) => !d[i + 3] || ground.every((v, k) => Math.abs(d[i + k] - v) <= 1);
  let sum = 0, count = 0;
  for (let i = 0; i < p.length; i += 4 * step) {
    if (bare(p, i) && bare(q, i)) continue;
    sum += deltaE(lab(p[i], p[i + 1], p[i + 2]), lab(q[i], q[i + 1], q[i + 2]));
    count++;
  }
  return count ? sum / count : 0;
}
