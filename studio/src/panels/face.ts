// Which face performs: the shipped one or a GLB of one's own, with what of it can move.
import * as api from '../api';
import { button, make, showFault } from '../dom';
import type { Recipe } from 'mien-viewer';
import type { Session } from '../session';
import type { Stage } from '../stage';

interface Report { meshes: { mesh: string; driven: Record<string, Recipe>; unknown: string[] }[]; nodes: Record<string, string> }

export class FacePanel {
  readonly element = make('div', { class: 'panel', id: 'panel-face' });
  id: string;
  private readonly known = new Map<string, Record<string, Recipe>>();
  private readonly file = make('input', { type: 'file', accept: '.glb,.vrm,model/gltf-binary', class: 'visually-hidden', id: 'field-face' });
  private readonly report = make('div', { class: 'report', 'aria-live': 'polite' });

  constructor(private readonly session: Session, private readonly stage: Stage, private readonly shown: () => void) {
    this.id = session.about.default_face;
    this.element.append(
      make('p', { class: 'help' }, 'Any GLB or VRM whose morph targets are named like ARKit’s shapes or like visemes.'),
      make('div', { class: 'actions' }, make('label', { class: 'button', for: 'field-face' }, 'Open a GLB …'), this.file,
        button('Default face', () => void this.show(this.session.about.default_face), { id: 'default-face' })),
      make('p', { class: 'fault', id: 'fault-face', role: 'alert', hidden: true }), this.report);
    this.file.addEventListener('change', () => void this.upload(this.file.files?.[0]));
  }

  async show(id: string, recipes?: Record<string, Recipe>): Promise<void> {
    await this.stage.show(await api.face(id), recipes ?? this.known.get(id));
    if (recipes !== undefined) this.known.set(id, recipes);
    this.id = id;
    if (id === this.session.about.default_face) this.report.replaceChildren();
    this.shown();
  }

  async upload(file: File | undefined): Promise<void> {
    this.file.value = '';
    if (file === undefined) return;
    showFault('face', null);
    await this.session.work(async () => {
      const { face, report } = await api.addFace(file);
      const told = report as Report;
      await this.show(face, Object.assign({}, ...told.meshes.map(({ driven }) => driven)) as Record<string, Recipe>);
      this.tell(file.name, told);
    });
  }

  private tell(name: string, { meshes, nodes }: Report): void {
    const rows = meshes.filter(({ driven, unknown }) => Object.keys(driven).length + unknown.length > 0).map(({ mesh, driven, unknown }) =>
      make('li', {}, `${mesh}: ${Object.keys(driven).length} targets move`,
        unknown.length === 0 ? null : make('p', { class: 'help' }, `not known, they rest: ${unknown.join(', ')}`)));
    const parts = { head: 'head', eyeLeft: 'left eye', eyeRight: 'right eye' };
    const missing = Object.entries(parts).filter(([part]) => !(part in nodes)).map(([, told]) => told);
    this.report.replaceChildren(make('h3', {}, name), make('ul', {}, ...rows,
      make('li', {}, missing.length === 0 ? 'head and eyes turn' : `no node for ${missing.join(', ')}: stays still`)));
  }
}
