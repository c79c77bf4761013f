// The head's three angles and eyes' looks as turns. Angles: degrees, yaw then pitch then roll about the moved axes;
// positive to the speaker's left, up, and to the speaker's left shoulder (y up, z out of the face).
import { Euler, MathUtils, Quaternion } from 'three';

const scratch = new Euler();

/** The turn of three angles, in `into`. */
export function turnOf(yaw: number, pitch: number, roll: number, into: Quaternion): Quaternion {
  const { degToRad } = MathUtils;
  return into.setFromEuler(scratch.set(degToRad(-pitch), degToRad(yaw), degToRad(-roll), 'YXZ'));
}

/** Yaw, pitch and roll of a turn, in degrees. */
export function anglesOf(turn: Quaternion): [number, number, number] {
  const { radToDeg } = MathUtils;
  scratch.setFromQuaternion(turn, 'YXZ');
  return [radToDeg(scratch.y), -radToDeg(scratch.x), -radToDeg(scratch.z)];
}
