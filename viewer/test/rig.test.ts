import { Bone, Object3D, Quaternion, Vector3 } from 'three';
import { describe, expect, it } from 'vitest';
import { channelOf, FaceRig, MienFace, MotionClip, recipesOf } from '../src/index.js';
import { WEIGHTS } from '../src/tables.js';
import { group, mesh, text } from './helpers.js';

describe('names of morph targets', () => {
  it.each([
    ['jawOpen', 'jawOpen'], ['blendShape1.jaw_open', 'jawOpen'], ['browDown_L', 'browDownLeft'],
    ['MOUTHSMILERIGHT', 'mouthSmileRight'], ['eyeBlink_R', 'eyeBlinkRight'],
  ])('%s is %s', (name, channel) => expect(channelOf(name)).toBe(channel));
  it('means what it means to mien itself', () => {
    const told = JSON.parse(text('names.json')) as Record<string, Record<string, number>>;
    const names = Object.keys(told);
    const found = recipesOf(names);
    names.forEach((name, place) => expect(found[place], name).toEqual(told[name]));
  });
  it('of a kind of which there are too few is not trusted', () => {
    expect(recipesOf(['A', 'hat'])).toEqual([{}, {}]);
    expect(recipesOf([''])).toEqual([{}]);
  });
});

describe('a rig', () => {
  it('drives several meshes, in whatever order and spelling', () => {
    const skin = mesh('skin', ['unknown', 'browDown_L', 'jaw_open']);
    const teeth = mesh('teeth', ['jawOpen']);
    const rig = new FaceRig(group(skin, teeth));
    rig.apply(['jawOpen', 'browDownLeft'], [0.5, 0.25]);
    expect(skin.morphTargetInfluences).toEqual([0, 0.25, 0.5]);
    expect(teeth.morphTargetInfluences).toEqual([0.5]);
    expect([...rig.channels].sort()).toEqual(['browDownLeft', 'jawOpen']);
    expect(rig.unknown).toEqual(['skin: unknown']);
    rig.apply(['jawOpen'], [2]); // kept within 0..1; what is not given rests
    expect(skin.morphTargetInfluences).toEqual([0, 0, 1]);
  });
  it('lets visemes rest where there are ARKit shapes, and halves of one brow follow it', () => {
    const both = mesh('face', [...WEIGHTS.slice(0, 20), 'viseme_aa', 'browInnerUp_L']);
    const rig = new FaceRig(both);
    rig.apply(['jawOpen', 'browInnerUp'], [1, 0.5]);
    expect(both.morphTargetInfluences?.slice(20)).toEqual([0, 0.5]);
  });
  it('takes what mien has found out about a face', () => {
    const odd = mesh('face', ['Bouche_01', 'jawOpen']);
    new FaceRig(odd, { recipes: { Bouche_01: { jawOpen: 0.5 } } }).apply(['jawOpen'], [1]);
    expect(odd.morphTargetInfluences).toEqual([0.5, 0]);
  });
  it('plays a target that no channel moves by a motion of that very name', () => {
    const odd = mesh('face', ['wobble']);
    new FaceRig(odd).apply(['wobble'], [0.75]);
    expect(odd.morphTargetInfluences).toEqual([0.75]);
  });
  it('turns head and eyes about the axes of the face, however their bones stand', () => {
    const hips = new Bone();
    hips.quaternion.setFromAxisAngle(new Vector3(1, 0, 0), 1.1);
    const head = new Bone();
    head.name = 'mixamorigHead';
    head.quaternion.setFromAxisAngle(new Vector3(0, 0, 1), 0.7);
    const eye = new Object3D();
    eye.name = 'eye_left';
    head.add(eye);
    hips.add(head);
    const stage = group(hips);
    stage.rotation.y = 2; // where the whole face stands in the scene must not matter
    stage.updateMatrixWorld(true);
    const world = (node: Object3D): Vector3 => new Vector3(0, 0, 1).applyQuaternion(node.getWorldQuaternion(new Quaternion()));
    const start = stage.getWorldQuaternion(new Quaternion());
    const rest = new Vector3(0, 0, 1).applyQuaternion(start.clone().invert()).applyQuaternion(head.getWorldQuaternion(new Quaternion()));
    const rig = new FaceRig(hips);
    rig.apply(['headYaw', 'eyeLookOutLeft'], [90, 1]);
    stage.updateMatrixWorld(true);
    const turn = new Quaternion().setFromAxisAngle(new Vector3(0, 1, 0), Math.PI / 2);
    const wanted = new Vector3(0, 0, 1)
      .applyQuaternion(head0()).applyQuaternion(turn).applyQuaternion(start);
    expect(world(head).distanceTo(wanted)).toBeLessThan(1e-6);
    expect(rest.length()).toBeCloseTo(1, 6);
    rig.apply([], []);
    expect(head.quaternion.angleTo(new Quaternion().setFromAxisAngle(new Vector3(0, 0, 1), 0.7))).toBeLessThan(1e-6);

    function head0(): Quaternion {
      return new Quaternion().setFromAxisAngle(new Vector3(1, 0, 0), 1.1)
        .multiply(new Quaternion().setFromAxisAngle(new Vector3(0, 0, 1), 0.7));
    }
  });
  it('says when nothing could move', () => {
    expect(() => new MienFace(group(mesh('box', [])))).toThrow(/nothing could move/);
  });
});

describe('a face that performs', () => {
  it('keeps time with any clock', async () => {
    const face = mesh('face', ['jawOpen']);
    const performer = new MienFace(face);
    let seconds = 0;
    await performer.play(new MotionClip(['jawOpen'], 10, Float32Array.of(0, 1, 0)), { clock: () => seconds });
    for (const [at, value] of [[0, 0], [0.05, 0.5], [0.1, 1], [0.15, 0.5], [9, 0]] as const) {
      seconds = at;
      performer.update();
      expect(face.morphTargetInfluences?.[0]).toBeCloseTo(value, 5);
    }
    seconds = 0.1;
    performer.stop();
    performer.update();
    expect(face.morphTargetInfluences?.[0]).toBe(0);
  });
  it('starts the sound it is given', async () => {
    const audio = { currentTime: 0, paused: true, playbackRate: 1, play: async () => { audio.paused = false; } };
    const performer = new MienFace(mesh('face', ['jawOpen']));
    await performer.play(new MotionClip(['jawOpen'], 10, Float32Array.of(0, 1)), { audio: audio as unknown as HTMLMediaElement });
    expect(audio.paused).toBe(false);
  });
});
