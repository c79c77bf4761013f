// The take as files.
import * as api from '../api';
import { field, make, showFault } from '../dom';
import type { Session } from '../session';

const FIRST = ['.mp4', '.glb'];

export class ExportPanel {
  readonly element = make('form', { class: 'panel', id: 'panel-export', 'aria-label': 'Export' });
  private readonly go = make('button', { type: 'submit', class: 'primary', id: 'export', disabled: true }, 'Export');
  private readonly results = make('ul', { class: 'results', 'aria-label': 'Files', 'aria-live': 'polite' });
  private readonly boxes: HTMLInputElement[];
  /** Whether files are being made that nobody has yet. */
  unsaved = false;

  constructor(private readonly session: Session, private readonly look: () => { face: string; light: string; camera: string }) {
    const { about } = session;
    const formats = about.formats ?? about.exports.map((suffix) => ({ suffix, title: '', loses: '' }));
    this.boxes = formats.map(({ suffix }) => make('input', { type: 'checkbox', value: suffix, checked: FIRST.includes(suffix), id: `format${suffix}` }));
    const rows = formats.map(({ suffix, title, loses }, place) => make('label', { class: 'format', title: loses === '' ? '' : `loses: ${loses}` },
      this.boxes[place], make('b', {}, suffix.includes('%') ? '.png …' : suffix), make('span', {}, title)));
    const list = make('div', { class: 'formats', role: 'group', 'aria-label': 'Formats' }, ...rows);
    this.element.append(field('Formats', 'formats', list), make('div', { class: 'actions' }, this.go), this.results);
    this.element.addEventListener('submit', (event) => {
      event.preventDefault();
      void this.export();
    });
    session.on('take', () => { this.go.disabled = false; });
    session.on('busy', (job) => { this.go.disabled = job !== null || session.take === undefined; });
  }

  private async export(): Promise<void> {
    const { session } = this;
    const formats = this.boxes.filter(({ checked }) => checked).map(({ value }) => value);
    if (formats.length === 0) {
      session.emit('problem', { message: 'Choose a format.', field: 'formats' });
      return;
    }
    this.unsaved = true;
    await session.work(async (signal) => {
      await session.settled();
      const { face, light, camera } = this.look();
      const asked = {
        formats, ...(face === session.about.default_face ? {} : { face }),
        ...(session.about.lights.includes(light) ? { light } : {}), ...(session.about.cameras.includes(camera) ? { camera } : {}),
      };
      showFault('formats', null);
      const job = await api.finished(await api.startExport(session.take?.take ?? '', asked), (told) => session.emit('busy', told), signal);
      if (job.file) this.offer(job.file);
    });
    this.unsaved = false;
  }

  private offer(address: string): void {
    const name = decodeURIComponent(address.split('/').pop() ?? 'file');
    const link = make('a', { href: address, download: name }, name);
    this.results.prepend(make('li', {}, link));
    this.results.scrollIntoView({ block: 'nearest' });
    link.click();
  }
}
