// Curves through keys: the same formulas as mien.text.parameter_curves and mien.text.intensity.
import type { Blend, Tangent } from './types';

/** Seconds, value, and how the curve passes there, where that is asked for. */
export type Point = readonly [number, number, Tangent?];
const LIKE: Readonly<Record<Blend, Tangent>> = { spline: 'auto', smooth: 'flat', linear: 'linear', hold: 'step' };
const own = (points: readonly Point[]): boolean => points.some(([, , tangent]) => tangent !== undefined);

/** How the curve passes a key: as it asks for, else as the whole curve has it. */
export const tangentAt = (point: Point, blend: Blend): Tangent => point[2] ?? LIKE[blend];

/** Cubics whose slopes at the keys are those that the keys ask for (mien.text.key_tangents). */
function throughTangents(points: readonly Point[], at: number, blend: Blend): number {
  let place = 0;
  while (place < points.length - 2 && (points[place + 1] as Point)[0] <= at) place++;
  const [before, after] = [points[place] as Point, points[place + 1] as Point];
  const [[t0, v0], [t1, v1]] = [before, after];
  const [leaves, comes] = [tangentAt(before, blend), tangentAt(after, blend)];
  if (leaves === 'step') return v0;
  const width = t1 - t0;
  if (width <= 0) return v1;
  const chord = (v1 - v0) / width;
  const sloped = (tangent: Tangent, i: number): number => (tangent === 'flat' ? 0 : tangent === 'linear' ? chord : points.length > 2 ? slope(points, i) : chord);
  const arrives = comes === 'step' && leaves === 'linear' ? 'linear' : comes;
  const [x, a, b] = [(at - t0) / width, sloped(leaves, place), sloped(arrives, place + 1)];
  return v0 * (1 + 2 * x) * (1 - x) ** 2 + a * width * x * (1 - x) ** 2 + v1 * x * x * (3 - 2 * x) - b * width * x * x * (1 - x);
}

/** The value at a moment; held before the first and after the last point. `smooth`: half a cosine; `spline`: monotone cubic. */
export function held(points: readonly Point[], at: number, blend: Blend): number {
  const first = points[0];
  const last = points[points.length - 1];
  if (first === undefined || last === undefined) return 0;
  if (at <= first[0]) return first[1];
  if (at >= last[0]) return last[1];
  if (own(points)) return throughTangents(points, at, blend);
  if (blend === 'spline' && points.length > 2) return cubic(points, at);
  let place = 0;
  while ((points[place + 1] as Point)[0] <= at) place++;
  const [t0, v0] = points[place] as Point;
  const [t1, v1] = points[place + 1] as Point;
  if (blend === 'hold') return v0;
  const share = t1 > t0 ? (at - t0) / (t1 - t0) : 0;
  return v0 + (v1 - v0) * (blend === 'smooth' ? (1 - Math.cos(Math.PI * share)) / 2 : share);
}

/** How much a curve counts: 1 from its first point to its last, fading over `fade` seconds on both sides. */
export function counts(points: readonly Point[], at: number, fade: number): number {
  const first = points[0];
  const last = points[points.length - 1];
  if (first === undefined || last === undefined) return 0;
  const outside = Math.max(first[0] - at, at - last[0], 0);
  if (fade === 0) return outside === 0 ? 1 : 0;
  return 1 - Math.min(outside / fade, 1);
}

/** An intensity at a moment; `smooth` is a monotone cubic through three points or more. */
export function intensityAt(points: readonly Point[], at: number, blend: Blend): number {
  if (own(points)) return Math.min(Math.max(held(points, at, blend === 'linear' ? 'linear' : 'spline'), 0), 1);
  if (blend === 'linear' || points.length < 3) return held(points, at, 'linear');
  const first = points[0] as Point;
  const last = points[points.length - 1] as Point;
  return Math.min(Math.max(cubic(points, Math.min(Math.max(at, first[0]), last[0])), 0), 1);
}

/** The monotone cubic through three points or more (PCHIP), at a moment between the first and the last. */
function cubic(points: readonly Point[], now: number): number {
  let place = 0;
  while (place < points.length - 2 && (points[place + 1] as Point)[0] <= now) place++;
  const [t0, v0] = points[place] as Point;
  const [t1, v1] = points[place + 1] as Point;
  const width = t1 - t0;
  const x = (now - t0) / width;
  const [a, b] = [slope(points, place), slope(points, place + 1)];
  return v0 * (1 + 2 * x) * (1 - x) ** 2 + a * width * x * (1 - x) ** 2 + v1 * x * x * (3 - 2 * x) - b * width * x * x * (1 - x);
}

/** Slope at a point: Fritsch and Butland's weighted harmonic mean, three-point rule at the ends (PCHIP). */
function slope(points: readonly Point[], place: number): number {
  const gap = (i: number): number => (points[i + 1] as Point)[0] - (points[i] as Point)[0];
  const rise = (i: number): number => ((points[i + 1] as Point)[1] - (points[i] as Point)[1]) / gap(i);
  const end = points.length - 1;
  if (place === 0) return atEnd(gap(0), gap(1), rise(0), rise(1));
  if (place === end) return atEnd(gap(end - 1), gap(end - 2), rise(end - 1), rise(end - 2));
  const [before, after] = [rise(place - 1), rise(place)];
  if (before * after <= 0) return 0;
  const [w1, w2] = [2 * gap(place) + gap(place - 1), gap(place) + 2 * gap(place - 1)];
  return (w1 + w2) / (w1 / before + w2 / after);
}

function atEnd(h0: number, h1: number, m0: number, m1: number): number {
  const found = ((2 * h0 + h1) * m0 - h0 * m1) / (h0 + h1);
  if (Math.sign(found) !== Math.sign(m0)) return 0;
  return Math.sign(m0) !== Math.sign(m1) && Math.abs(found) > 3 * Math.abs(m0) ? 3 * m0 : found;
}
