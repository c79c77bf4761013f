// The deformation editor (Frydrych et al. 2003): the tree's parameters, their axes and pivots, a brush for their weights.
import * as api from '../api';
import { button, download, field, make, options, showFault } from '../dom';
import { RigEditor } from '../rig/editor';
import { isSkeletal, type ParameterData, type TreeData } from '../rig/tree';
import type { Session } from '../session';
import type { Stage } from '../stage';

const DEGREES = 30;
const FACTOR = 1.5;

export class RigPanel {
  readonly element = make('div', { class: 'panel', id: 'panel-rig' });
  editor: RigEditor | undefined;
  private shown = false;
  private readonly file = make('input', { type: 'file', accept: '.tree,.txt,text/plain', class: 'visually-hidden', id: 'field-tree' });
  private readonly body = make('div', { class: 'rig', hidden: true });
  private readonly parameter = make('select');
  private readonly facts = make('p', { class: 'help' });
  private readonly value = make('input', { type: 'range', step: 'any' });
  private readonly numbers = make('div', {});
  private readonly size = make('input', { type: 'range', min: 2, max: 40, step: 1, value: 12 });
  private readonly strength = make('input', { type: 'range', min: 0.02, max: 1, step: 0.02, value: 0.25 });
  private readonly mirrored = make('input', { type: 'checkbox', checked: true });
  private readonly erase = make('input', { type: 'checkbox' });
  private readonly paint = button('Paint', () => this.setPainting(!(this.editor?.painting ?? false)), { 'aria-pressed': 'false', id: 'paint' });
  private readonly undo = button('Undo', () => this.editor?.undo(), { disabled: true });
  private readonly own = button('Tree of this face', () => void this.load(this.faceNow().id), { id: 'load-tree' });
  /** The server's name for the tree that is open. */
  id = '';
  private face = '';

  /** @param faceNow the face that is shown; `leave` is called when the editor gives the stage back */
  constructor(private readonly session: Session, private readonly stage: Stage, private readonly faceNow: () => { id: string; name: string }, private readonly leave: () => void) {
    this.element.append(
      make('p', { class: 'help' }, 'A face can be moved by a tree of turns (jaw, eyes, head) and shifts (lips, brows …) instead of its shapes. Here you see what each of them moves, and change it. It works on any face that the Face panel shows.'),
      make('div', { class: 'actions' }, this.own,
        make('label', { class: 'button', for: 'field-tree' }, 'Open a .tree …'), this.file),
      make('p', { class: 'fault', id: 'fault-config', role: 'alert', hidden: true }), this.body);
    this.body.append(
      field('Parameter', 'parameter', this.parameter), this.facts, field('Try it', 'value', this.value), this.numbers,
      make('h3', {}, 'Weights'),
      make('div', { class: 'actions' }, this.paint, this.undo),
      make('div', { class: 'pair' }, field('Size of the brush', 'size', this.size), field('Strength', 'strength', this.strength)),
      make('div', { class: 'ticks' }, make('label', {}, this.mirrored, 'mirrored'), make('label', {}, this.erase, 'take away')),
      make('p', { class: 'help' }, 'While painting, the right button (or two fingers) turns the view.'),
      make('div', { class: 'actions' }, button('Save the configuration', () => void this.save(), { class: 'primary', id: 'save-tree' })));
    this.listen();
  }

  private listen(): void {
    this.file.addEventListener('change', () => void this.read(this.file.files?.[0]));
    this.parameter.addEventListener('change', () => this.editor?.choose(this.parameter.value));
    this.value.addEventListener('input', () => {
      if (this.editor === undefined) return;
      this.editor.values.set(this.editor.chosen, Number(this.value.value));
      this.editor.show(false);
    });
    for (const control of [this.size, this.strength, this.mirrored, this.erase]) control.addEventListener('input', () => this.setBrush());
    const canvas = this.stage.canvas.parentElement as HTMLElement;
    canvas.addEventListener('pointerdown', (event) => this.stroke(event), { capture: true });
  }

  private setBrush(): void {
    if (this.editor === undefined) return;
    this.editor.brush = { radius: Number(this.size.value), strength: Number(this.strength.value), mirrored: this.mirrored.checked, erase: this.erase.checked };
  }

  private setPainting(on: boolean): void {
    if (this.editor === undefined) return;
    this.editor.painting = on;
    this.paint.setAttribute('aria-pressed', String(on));
    this.stage.canvas.classList.toggle('painting', on);
  }

  private stroke(event: PointerEvent): void {
    const { editor } = this;
    if (editor === undefined || !this.shown || !editor.painting || event.button !== 0 || !event.isPrimary) return;
    const area = this.stage.canvas.getBoundingClientRect();
    if (!editor.begin(event.clientX - area.left, event.clientY - area.top)) return;
    event.stopPropagation();
    const move = (to: PointerEvent): void => editor.stroke(to.clientX - area.left, to.clientY - area.top);
    window.addEventListener('pointermove', move);
    window.addEventListener('pointerup', () => {
      window.removeEventListener('pointermove', move);
      editor.end();
    }, { once: true });
  }

  // ------------------------------------------------------------ trees

  private async load(id: string): Promise<void> {
    showFault('config', null);
    await this.session.work(async () => {
      this.session.emit('busy', { state: 'running', step: 'reading the tree' });
      const { config, face } = await api.getRig(id);
      const [influences, shapes] = await Promise.all([api.getInfluences(id), api.getRigMesh(id)]);
      const shown = this.shown;
      this.hide();
      [this.id, this.face] = [id, face];
      this.editor = new RigEditor(this.stage, config, influences, shapes, () => this.tell());
      this.setBrush();
      options(this.parameter, config.parameters.filter(({ kind }) => kind !== 'fixed').map((one): [string, string] => [one.name, `${'  '.repeat(depth(config.parameters, one))}${one.name}`]), this.editor.chosen);
      this.body.hidden = false;
      this.tell();
      if (shown || document.body.dataset['tab'] === 'rig') await this.show();
    });
  }

  private async read(file: File | undefined): Promise<void> {
    this.file.value = '';
    if (file === undefined) return;
    try {
      const { rig } = await api.addRig(await file.text(), this.faceNow().id);
      await this.load(rig);
    } catch (problem) {
      this.session.tell(problem, 'config');
    }
  }

  /** Takes the stage, if a tree is open. */
  async show(): Promise<void> {
    this.own.textContent = `Tree of ${this.faceNow().name}`;
    if (this.editor === undefined || this.shown) return;
    this.shown = true;
    this.editor.open();
  }

  /** Gives the stage back. */
  hide(): void {
    if (!this.shown) return;
    this.shown = false;
    this.setPainting(false);
    this.editor?.close();
    this.leave();
  }

  get active(): boolean { return this.shown; }

  private tell(): void {
    const { editor } = this;
    const parameter = editor?.parameter;
    if (editor === undefined || parameter === undefined) return;
    this.undo.disabled = !editor.canUndo;
    const drives = Object.entries(parameter.drives).map(([name, gain]) => `${gain} × ${name}`).join(' + ') || 'nothing';
    this.facts.textContent = `${parameter.kind}, ${isSkeletal(editor.tree, parameter) ? 'skeletal' : 'surface'}, ${parameter.parent === null ? 'no parent' : `child of ${parameter.parent}`}; driven by ${drives}`;
    const reach = parameter.kind === 'rotation' ? DEGREES : FACTOR;
    const [low, high] = parameter.limits ?? [-reach, reach];
    this.value.min = String(low);
    this.value.max = String(high);
    this.value.value = String(editor.values.get(editor.chosen) ?? 0);
    if (!this.numbers.contains(document.activeElement)) this.numbers.replaceChildren(...this.vectors(parameter));
  }

  private vectors(parameter: ParameterData): HTMLElement[] {
    const names = parameter.kind === 'rotation' ? ([['axis', 'Axis'], ['pivot', 'Pivot, mm']] as const) : ([['translation', 'Translation at value 1, mm']] as const);
    return names.map(([name, label]) => {
      const inputs = [0, 1, 2].map((place) => {
        const input = make('input', { type: 'number', step: name === 'axis' ? 0.05 : 0.5, value: round(parameter[name]?.[place] ?? 0), 'aria-label': `${label}, ${'xyz'[place]}` });
        input.addEventListener('change', () => {
          const vector = inputs.map(({ value }) => Number(value));
          if (vector.every(Number.isFinite)) this.editor?.change({ [name]: vector });
        });
        return input;
      });
      return make('fieldset', { class: 'vector' }, make('legend', {}, label), ...inputs);
    });
  }

  private async save(): Promise<void> {
    const { editor } = this;
    if (editor === undefined) return;
    showFault('config', null);
    await this.session.work(async () => {
      this.session.emit('busy', { state: 'running', step: 'saving the configuration' });
      const config = editor.config();
      try {
        this.id = (await api.putRig(this.id, config)).rig;
      } catch (problem) {
        throw new api.ApiError(await this.faults(config, problem), 'config');
      }
      download('face.tree', await api.rigText(this.id), 'text/plain');
    });
  }

  /** Why a configuration was refused, with the lines at fault where there are any. */
  private async faults(config: TreeData, problem: unknown): Promise<string> {
    const { faults } = await api.checkRig(config, this.face).catch(() => ({ faults: [] as api.RigFault[] }));
    if (faults.length === 0) return problem instanceof Error ? problem.message : String(problem);
    return faults.slice(0, 3).map(({ line, text }) => (line ? `line ${line}: ${text}` : text)).join('; ');
  }
}

const round = (value: number): number => Math.round(value * 1e4) / 1e4;

function depth(parameters: readonly ParameterData[], { parent }: ParameterData): number {
  let [count, at] = [0, parent];
  while (at !== null && count < parameters.length) {
    count++;
    at = parameters.find(({ name }) => name === at)?.parent ?? null;
  }
  return count;
}
