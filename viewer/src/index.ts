export { contextClock, mediaClock, wallClock, type Clock } from './clocks.js';
export { MienError } from './errors.js';
export { frameBox, frameFace, movingBox, type FrameOptions } from './framing.js';
export { readGlb } from './glb.js';
export { dressFace, shaded } from './materials.js';
export { MotionClip, type Facts, type Motion, type Span } from './motion.js';
export { channelOf, recipesOf, type Recipe } from './names.js';
export { readAnimation } from './native.js';
export { loadMotion, MienFace, type PlayOptions } from './player.js';
export { FaceRig, type RigOptions } from './rig.js';
export {
  MienStream, readFrame, readGreeting, STREAM_VERSION,
  type Frame, type Greeting, type StreamOptions, type StreamStats,
} from './stream.js';
export { anglesOf, turnOf } from './turns.js';
