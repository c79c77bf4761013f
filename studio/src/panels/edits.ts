// The layer of edits as a list, with what could not be applied.
import { button, download, icon, ICONS, make, showFault } from '../dom';
import { describe, without } from '../layer';
import type { Session } from '../session';

export class EditsPanel {
  readonly element = make('div', { class: 'panel', id: 'panel-edits' });
  private readonly list = make('ul', { class: 'edits', 'aria-label': 'Edits' });
  private readonly notes = make('ul', { class: 'notes', 'aria-label': 'Notes' });
  private readonly open = make('input', { type: 'file', accept: '.json,application/json', class: 'visually-hidden', id: 'field-layer' });

  constructor(private readonly session: Session) {
    const fault = make('p', { class: 'fault', id: 'fault-layer', role: 'alert', hidden: true });
    this.element.append(
      make('p', { class: 'help' }, 'Edits lie over the performance, tied to words and phones: they stay when the line is performed again.'),
      this.list,
      make('div', { class: 'actions' }, button('Save edits', () => this.save(), { id: 'save-layer' }),
        make('label', { class: 'button', for: 'field-layer' }, 'Open edits …'), this.open),
      fault, make('h3', {}, 'Notes'), this.notes);
    this.open.addEventListener('change', () => void this.load());
    session.on('layer', () => this.show());
    session.on('lost', () => this.show());
    session.on('take', ({ take }) => this.notes.replaceChildren(...(take.notes.length === 0 ? [make('li', { class: 'quiet' }, 'none')]
      : take.notes.map(({ kind, message }) => make('li', { class: kind }, message)))));
    this.show();
  }

  private show(): void {
    const { layer, lost } = this.session;
    const rows = layer.edits.map((edit, place) => {
      const reasons = lost.filter((entry) => entry.edit === place).map(({ why }) => make('p', { class: 'lost' }, `not applied: ${why}`));
      return make('li', { class: `edit ${edit.kind}` }, make('div', {}, describe(edit), ...reasons),
        button(`Remove ${describe(edit)}`, () => this.session.commit(without(this.session.layer, place)), { class: 'small' }, icon(ICONS.cross)));
    });
    if (this.session.request.times) { // no edit of the layer: the line itself is performed with them
      const told = 'Words and phones as you corrected them';
      rows.unshift(make('li', { class: 'edit given' }, make('div', {}, told), button(`Remove: ${told}`, () => void this.session.perform({ times: null }), { class: 'small' }, icon(ICONS.cross))));
    }
    this.list.replaceChildren(...(rows.length > 0 ? rows : [make('li', { class: 'quiet' }, 'No edits yet: drag a border, a point or a key on the timeline.')]));
  }

  private save(): void {
    download('edits.json', `${JSON.stringify(this.session.layer, null, 1)}\n`, 'application/json');
  }

  private async load(): Promise<void> {
    const file = this.open.files?.[0];
    this.open.value = '';
    if (file === undefined) return;
    showFault('layer', null);
    try {
      await this.session.loadLayer(JSON.parse(await file.text()));
    } catch (problem) {
      this.session.emit('problem', { message: `${file.name} is not JSON: ${String(problem).replace(/\s+/g, ' ')}`, field: 'layer' });
    }
  }
}
