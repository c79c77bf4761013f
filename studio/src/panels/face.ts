// Which face performs: the shipped one or a GLB of one's own, with what of it can move.
import * as api from '../api';
import { button, make, showFault } from '../dom';
import type { Recipe } from 'mien-viewer';
import { HeadPanel } from './head';
import type { Session } from '../session';
import type { Stage } from '../stage';

interface Report { verdict?: string; meshes: { mesh: string; driven: Record<string, Recipe>; unknown: string[] }[]; nodes: Record<string, string> }

export class FacePanel {
  readonly element = make('div', { class: 'panel', id: 'panel-face' });
  id: string;
  private readonly known = new Map<string, Record<string, Recipe>>();
  private readonly pictures = new Map<string, HTMLCanvasElement>();
  private readonly reports = new Map<string, [name: string, report: Report]>();
  private readonly file = make('input', { type: 'file', accept: '.glb,.vrm,model/gltf-binary', class: 'visually-hidden', id: 'field-face' });
  private readonly report = make('div', { class: 'report', 'aria-live': 'polite' });
  private readonly cast = make('div', { class: 'cast', role: 'group', 'aria-label': 'Faces' });

  readonly head: HeadPanel;

  constructor(private readonly session: Session, private readonly stage: Stage, private readonly shown: () => void) {
    this.head = new HeadPanel(session, stage, async (face) => { await this.list(); await this.show(face); });
    this.id = session.about.default_face;
    this.element.append(
      this.cast,
      make('p', { class: 'help' }, 'Or a face of your own, with morph targets named like ARKit’s shapes or like visemes, or a head that cannot move yet: it gets mien’s shapes. Drop it anywhere.'),
      make('div', { class: 'actions' }, make('label', { class: 'button', for: 'field-face' }, 'Open a GLB or VRM …'), this.file),
      make('p', { class: 'fault', id: 'fault-face', role: 'alert', hidden: true }), this.report, this.head.element);
    this.file.addEventListener('change', () => void this.upload(this.file.files?.[0]));
  }

  /** What the face is called that is shown. */
  get name(): string { return this.cast.querySelector<HTMLElement>('[aria-pressed=true]')?.title ?? this.id; }

  /** All faces that can be shown, as pictures; those that were opened keep what drives them. */
  async list(): Promise<void> {
    const faces = await api.faces();
    for (const { face, name, report } of faces) {
      if (report === undefined) continue;
      this.known.set(face, recipesOf(report as Report));
      this.reports.set(face, [name, report as Report]);
    }
    this.cast.replaceChildren(...faces.map(({ face, name, picture }) => {
      const press = button(name, () => void this.show(face).catch((problem: unknown) => this.session.tell(problem, 'face')), { class: 'member', 'data-face': face, 'aria-pressed': String(face === this.id), title: name },
        picture === false ? this.pictures.get(face) ?? make('span', { class: 'own', 'aria-hidden': 'true' }, name.slice(0, 3)) : make('img', { src: `/api/faces/${face}.jpg`, alt: '', width: 72, height: 72, loading: 'lazy' }), make('span', {}, name));
      return press;
    }));
  }

  async show(id: string, recipes?: Record<string, Recipe>): Promise<void> {
    this.head.leave();
    const [glb, folds] = await Promise.all([api.face(id), api.folds(id).catch(() => null)]);
    await this.stage.show(glb, recipes ?? this.known.get(id), folds);
    if (recipes !== undefined) this.known.set(id, recipes);
    this.id = id;
    const placeholder = this.cast.querySelector(`[data-face="${CSS.escape(id)}"] .own`);
    if (placeholder !== null) this.picture(id, placeholder);
    for (const press of this.cast.querySelectorAll<HTMLElement>('.member')) press.setAttribute('aria-pressed', String(press.dataset['face'] === id));
    const report = this.reports.get(id);
    if (report === undefined) this.report.replaceChildren();
    else this.tell(...report);
    this.shown();
  }

  /** A small picture of a face of one's own, in the place of the word. */
  private picture(id: string, placeholder: Element): void {
    const canvas = make('canvas', { width: 144, height: 144, 'aria-hidden': 'true' });
    this.stage.portrait(canvas, undefined);
    this.pictures.set(id, canvas);
    placeholder.replaceWith(canvas);
    const solid = make('canvas', { width: canvas.width, height: canvas.height }); // a JPEG has no transparency
    const context = solid.getContext('2d') as CanvasRenderingContext2D;
    context.fillStyle = '#34373d';
    context.fillRect(0, 0, solid.width, solid.height);
    context.drawImage(canvas, 0, 0);
    solid.toBlob((drawn) => { if (drawn !== null) void api.keepPicture(id, drawn).catch(() => undefined); }, 'image/jpeg', 0.85); // for the next time
  }

  async upload(file: File | undefined): Promise<void> {
    this.file.value = '';
    if (file === undefined) return;
    showFault('face', null);
    let still = false;
    await this.session.work(async () => {
      const added = await api.addFace(file, file.name).catch((problem: unknown) => {
        if (!(problem instanceof api.ApiError) || problem.field !== 'head') throw problem;
        still = true;
      });
      if (added === undefined) return;
      const { face, report } = added;
      const told = report as Report;
      this.reports.set(face, [file.name, told]);
      await this.list();
      await this.show(face, recipesOf(told));
    });
    if (still) await this.head.open(file);
  }

  private tell(name: string, { meshes, nodes, verdict = 'This face can perform' }: Report): void {
    const driven = meshes.reduce((sum, mesh) => sum + Object.keys(mesh.driven).length, 0);
    const all = meshes.reduce((sum, mesh) => sum + Object.keys(mesh.driven).length + mesh.unknown.length, 0);
    const parts = { head: 'head', eyeLeft: 'left eye', eyeRight: 'right eye' };
    const missing = Object.entries(parts).filter(([part]) => !(part in nodes)).map(([, told]) => told);
    const rows = meshes.filter((mesh) => mesh.unknown.length > 0).map(({ mesh, unknown }) => make('li', { title: unknown.join(', ') }, `${mesh}: not known, they rest: ${unknown.slice(0, 8).join(', ')}${unknown.length > 8 ? ` and ${unknown.length - 8} more` : ''}`));
    this.report.replaceChildren(make('h3', {}, name), make('p', { class: 'verdict' }, `${verdict.charAt(0).toUpperCase()}${verdict.slice(1)}.`), make('p', { class: 'quiet' }, `${driven} of ${all} targets move; ${missing.length === 0 ? 'head and eyes turn' : `no node for ${missing.join(', ')}: still`}.`), make('ul', {}, ...rows));
  }
}

const recipesOf = ({ meshes }: Report): Record<string, Recipe> => Object.assign({}, ...meshes.map(({ driven }) => driven)) as Record<string, Recipe>;
