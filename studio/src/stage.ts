// The face in its light: three.js, drawn only when something has changed.
import { dressFace, FaceRig, frameBox, movingBox, type Recipe } from 'mien-viewer';
import {
  ACESFilmicToneMapping, Box3, Group, Mesh, PCFShadowMap, PerspectiveCamera, PMREMGenerator, Raycaster, Scene, SRGBColorSpace,
  Vector2, Vector3, WebGLRenderer, type Intersection, type Material, type Object3D, type Texture,
} from 'three';
import { OrbitControls } from 'three/addons/controls/OrbitControls.js';
import { RoomEnvironment } from 'three/addons/environments/RoomEnvironment.js';
import { LIGHTINGS, lampsOf, matt, VIEWS, type Quality, type View } from './looks';
import { readFace } from './loaders';
import { Folds, type FoldData } from './folds';
import { takeOver, type SparseMorphs } from './sparse_morphs';
import { FrameTimes } from './frame_times';

const FIELD = 22; // degrees
const SLOW_MS = 45; // the picture is made coarser where frames take longer than this
const FINEST = 2;

export class Stage {
  readonly renderer: WebGLRenderer;
  readonly times = new FrameTimes();
  readonly controls: OrbitControls;
  readonly camera = new PerspectiveCamera(FIELD, 1, 0.01, 100);
  rig: FaceRig | undefined;
  morphs: SparseMorphs[] = [];
  lighting = 'portrait';
  private readonly scene = new Scene();
  readonly quality: Quality;
  private face: Group | undefined;
  private folds: Folds | undefined;
  private other: Object3D | undefined;
  private lamps = new Group();
  private box = new Box3(new Vector3(-0.1, -0.1, -0.1), new Vector3(0.1, 0.1, 0.1));
  private region = this.box;
  private dirty = true;
  private posed: [readonly string[], ArrayLike<number>] = [[], []];
  private fineness: number;
  private shadows: boolean;

  constructor(readonly canvas: HTMLCanvasElement, private readonly backdrop: HTMLElement) {
    this.quality = chosenQuality();
    this.renderer = new WebGLRenderer({ canvas, antialias: this.quality === 'full', alpha: true, powerPreference: 'high-performance' });
    this.renderer.outputColorSpace = SRGBColorSpace;
    this.renderer.toneMapping = ACESFilmicToneMapping;
    this.renderer.toneMappingExposure = 1.0;
    this.renderer.shadowMap.enabled = true;
    this.renderer.shadowMap.type = PCFShadowMap;
    this.fineness = Math.min(globalThis.devicePixelRatio, FINEST);
    this.shadows = this.quality === 'full';
    if (this.quality === 'full') this.reflect();
    this.scene.add(this.lamps);
    this.controls = new OrbitControls(this.camera, canvas);
    this.controls.enablePan = true;
    this.controls.addEventListener('change', () => this.touch());
    new ResizeObserver(() => this.fit()).observe(backdrop);
    this.fit();
    this.light('portrait');
  }

  /** A room of soft lamps, for reflections. */
  private reflect(): void {
    const maker = new PMREMGenerator(this.renderer);
    this.scene.environment = maker.fromScene(new RoomEnvironment(), 0.04).texture;
    maker.dispose();
  }

  /** Asks for a new picture. */
  touch(): void { this.dirty = true; }

  /** Shows a GLB as the face; `recipes` say what drives its targets, where mien has found it out; `folds` lie on its skin. */
  async show(glb: ArrayBuffer, recipes?: Readonly<Record<string, Recipe>>, folds: FoldData | null = null): Promise<FaceRig> {
    const { scene } = await readFace(glb, this.renderer);
    const rig = new FaceRig(scene, recipes === undefined ? {} : { recipes });
    const meshes: Mesh[] = [];
    scene.traverse((part) => { if ((part as Mesh).isMesh) meshes.push(part as Mesh); });
    for (const mesh of meshes) {
      mesh.frustumCulled = false;
      mesh.castShadow = mesh.receiveShadow = true;
    }
    dressFace(scene, this.quality === 'full' ? undefined : matt);
    this.folds?.dispose();
    this.folds = folds === null ? undefined : new Folds(folds);
    this.folds?.lieOn(meshes);
    const region = movingBox(scene);
    this.morphs = takeOver(meshes);
    this.drop();
    this.face = scene;
    this.rig = rig;
    this.scene.add(scene);
    scene.visible = this.other === undefined;
    this.box = new Box3().setFromObject(scene);
    this.region = region;
    this.light(this.lighting);
    this.view('portrait');
    return rig;
  }

  private drop(): void {
    if (this.face === undefined) return;
    this.scene.remove(this.face);
    this.face.traverse((part) => {
      const mesh = part as Mesh;
      if (!mesh.isMesh) return;
      mesh.geometry.dispose();
      const materials: Material[] = Array.isArray(mesh.material) ? mesh.material : [mesh.material];
      for (const material of materials) {
        for (const value of Object.values(material)) if ((value as Texture | null)?.isTexture) (value as Texture).dispose();
        material.dispose();
      }
    });
  }

  /** Shows another object in the place of the face, framed like it (undefined: the face again). */
  instead(object: Object3D | undefined, box = object === undefined ? undefined : new Box3().setFromObject(object)): void {
    if (this.other !== undefined) this.scene.remove(this.other);
    this.other = object;
    if (this.face !== undefined) this.face.visible = object === undefined;
    if (object !== undefined && box !== undefined) {
      this.scene.add(object);
      this.camera.aspect = this.backdrop.clientWidth / Math.max(this.backdrop.clientHeight, 1);
      this.controls.target.copy(frameBox(box, this.camera, { fill: 1.15, height: 0.5, around: 20, above: 4 }));
      this.controls.minDistance = (box.max.y - box.min.y) * 0.1;
      this.controls.update();
    } else this.view('portrait');
    this.touch();
  }

  add(object: Object3D): void { this.scene.add(object); this.touch(); }
  remove(object: Object3D): void { this.scene.remove(object); this.touch(); }

  /** Meshes of the face. */
  meshes(): Mesh[] {
    const found: Mesh[] = [];
    this.face?.traverse((part) => { if ((part as Mesh).isMesh) found.push(part as Mesh); });
    return found;
  }

  /** What the first mesh with such a morph target stands at. */
  influence(target: string): number | undefined {
    for (const mesh of this.meshes()) {
      const place = mesh.morphTargetDictionary?.[target];
      if (place !== undefined) return mesh.morphTargetInfluences?.[place];
    }
    return undefined;
  }

  pose(channels: readonly string[], values: ArrayLike<number>): void {
    this.posed = [channels, values];
    this.moveTo(channels, values);
    this.touch();
  }

  private moveTo(channels: readonly string[], values: ArrayLike<number>): void {
    this.rig?.apply(channels, values);
    this.folds?.pose(channels, values);
  }

  /** A face at rest, moved by so much of an expression. */
  mask(mask: { channels: readonly string[]; values: readonly number[] } | undefined, strength: number): void {
    this.pose(mask?.channels ?? [], mask?.values.map((value) => value * strength) ?? []);
  }

  /** A second pose, shown beside the first; undefined: one face alone. */
  beside: { channels: readonly string[]; values: ArrayLike<number> } | undefined;

  /** Draws a small picture of the face with an expression into another canvas. */
  portrait(canvas: HTMLCanvasElement, mask: { channels: readonly string[]; values: readonly number[] } | undefined): void {
    if (this.rig === undefined) return;
    const { width: side } = canvas;
    const [before, camera] = [this.posed, new PerspectiveCamera(FIELD, 1, this.camera.near, this.camera.far)];
    this.aim(camera, { around: 0, above: 1, fill: 1.5, height: 0.5 });
    this.moveTo(mask?.channels ?? [], mask?.values ?? []);
    for (const morph of this.morphs) morph.update();
    const points = side / this.renderer.getPixelRatio();
    this.renderer.setScissorTest(true);
    this.renderer.setViewport(0, 0, points, points);
    this.renderer.setScissor(0, 0, points, points);
    this.renderer.render(this.scene, camera);
    const context = canvas.getContext('2d') as CanvasRenderingContext2D;
    context.clearRect(0, 0, side, side);
    context.drawImage(this.canvas, 0, this.canvas.height - side, side, side, 0, 0, side, side);
    this.renderer.setScissorTest(false);
    const { clientWidth, clientHeight } = this.backdrop;
    this.renderer.setViewport(0, 0, clientWidth, clientHeight);
    this.moveTo(...before);
    this.dirty = true;
    this.draw(false); // what is on the screen again
  }

  light(name: string): void {
    const lighting = LIGHTINGS[name] ?? LIGHTINGS['portrait'];
    if (lighting === undefined) return;
    this.lighting = name;
    this.scene.remove(this.lamps);
    for (const lamp of this.lamps.children) (lamp as { dispose?: () => void }).dispose?.();
    this.lamps = lampsOf(lighting, this.centre(), this.size(), this.shadows, this.quality);
    this.scene.add(this.lamps);
    this.scene.environmentIntensity = lighting.around;
    this.backdrop.style.background = `radial-gradient(120% 90% at 50% 38%, ${lighting.back[0]}, ${lighting.back[1]})`;
    this.touch();
  }

  view(name: string): void {
    const view = VIEWS[name] ?? VIEWS['portrait'];
    if (view === undefined) return;
    const { target, size } = this.aim(this.camera, view);
    this.controls.target.copy(target);
    this.controls.minDistance = size * 0.4;
    this.controls.maxDistance = size * 12;
    this.controls.update();
    this.touch();
  }

  /** Points a camera at what of the face moves. */
  private aim(camera: PerspectiveCamera, view: View): { target: Vector3; size: number } {
    return { target: frameBox(this.region, camera, view), size: this.region.max.y - this.region.min.y };
  }

  private centre(): Vector3 { return this.box.getCenter(new Vector3()); }
  private size(): number { return this.box.max.y - this.box.min.y || 1; }

  private fit(): void {
    const { clientWidth: width, clientHeight: height } = this.backdrop;
    if (width === 0 || height === 0) return;
    this.renderer.setPixelRatio(this.fineness);
    this.renderer.setSize(width, height, false);
    this.camera.aspect = width / height;
    this.camera.updateProjectionMatrix();
    this.touch();
  }

  /** Where a point of the picture (pixels of the canvas) meets one of the meshes. */
  under(x: number, y: number, meshes: Mesh[]): Intersection | undefined {
    const { width, height } = this.canvas.getBoundingClientRect();
    const caster = new Raycaster();
    caster.setFromCamera(new Vector2((x / width) * 2 - 1, 1 - (y / height) * 2), this.camera);
    return caster.intersectObjects(meshes, false)[0];
  }

  /** Draws if anything changed; `busy` says that pictures follow each other, so that their times mean something. */
  draw(busy: boolean): void {
    if (!this.dirty) {
      this.times.pause();
      return;
    }
    this.dirty = false;
    const began = performance.now();
    if (this.beside === undefined) this.picture();
    else this.pair(this.beside);
    this.times.add(performance.now() - began, busy);
    if (busy && this.times.slowerThan(SLOW_MS)) this.coarser();
  }

  private picture(): void {
    for (const morph of this.morphs) morph.update();
    this.renderer.render(this.scene, this.camera);
  }

  /** Two poses of the face, each in its half. */
  private pair(other: { channels: readonly string[]; values: ArrayLike<number> }): void {
    const { clientWidth: width, clientHeight: height } = this.backdrop;
    this.camera.aspect = width / 2 / height;
    this.camera.updateProjectionMatrix();
    this.renderer.setScissorTest(true);
    for (const half of [0, 1]) {
      this.moveTo(...(half === 0 ? this.posed : [other.channels, other.values] as const));
      this.renderer.setViewport((half * width) / 2, 0, width / 2, height);
      this.renderer.setScissor((half * width) / 2, 0, width / 2, height);
      this.picture();
    }
    this.renderer.setScissorTest(false);
    this.renderer.setViewport(0, 0, width, height);
    this.camera.aspect = width / height;
    this.camera.updateProjectionMatrix();
  }

  /** Fewer points, then no shadows: a face that keeps time is worth more than a fine one. */
  private coarser(): void {
    this.times.forgetPace();
    if (this.fineness > 1) this.fineness = 1;
    else if (this.shadows) {
      this.shadows = false;
      this.light(this.lighting);
    } else if (this.fineness > 0.35) this.fineness = this.fineness > 0.5 ? 0.5 : 0.35;
    else return;
    this.fit();
  }
}

/** What is asked for in the page's address (`?quality=full`), or else what the machine can draw. */
function chosenQuality(): Quality {
  const asked = new URLSearchParams(location.search).get('quality');
  if (asked === 'full' || asked === 'plain') return asked;
  const gl = document.createElement('canvas').getContext('webgl2'); // before the real one: smooth edges are chosen with that
  const known = gl?.getExtension('WEBGL_debug_renderer_info') ?? null;
  const name = gl === null || known === null ? '' : String(gl.getParameter(known.UNMASKED_RENDERER_WEBGL));
  gl?.getExtension('WEBGL_lose_context')?.loseContext();
  return /swiftshader|llvmpipe|software/i.test(name) ? 'plain' : 'full';
}
