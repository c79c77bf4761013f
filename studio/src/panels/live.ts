// Sends what the page shows to an engine, as it is shown.
import * as api from '../api';
import { button, icon, ICONS, make, options } from '../dom';
import type { Playback } from '../playback';
import type { Session } from '../session';

const KINDS: Readonly<Record<string, string>> = {
  livelink: 'Unreal and others: Live Link Face', vmc: 'VRM avatar with all 52 shapes: VMC', 'vmc-vrm': 'VRM avatar with the usual shapes: VMC', 'vmc-vrm1': 'VRM 1.0 avatar with the usual shapes: VMC',
};
const SCRUB_MS = 40;

export class LiveButton {
  readonly element: HTMLButtonElement;
  readonly dialog: HTMLDialogElement;
  private readonly kind = make('select', { id: 'field-kind' });
  private readonly to = make('input', { type: 'text', id: 'field-to', value: '127.0.0.1', spellcheck: 'false', 'aria-describedby': 'live-help' });
  private readonly subject = make('input', { type: 'text', id: 'field-subject', value: 'mien', maxlength: 60 });
  private readonly help = make('p', { class: 'help', id: 'live-help' });
  private readonly told = make('p', { class: 'fault', role: 'alert', hidden: true });
  private readonly go = make('button', { type: 'submit', class: 'primary' }, 'Send');
  private sending = false;
  private waiting = 0;

  constructor(private readonly session: Session, private readonly playback: Playback) {
    this.element = button('Send live to an engine', () => (this.sending ? void this.stop() : this.dialog.showModal()), { 'data-do': 'live', 'aria-pressed': 'false', title: 'Send live to an engine: Unreal, a VRM avatar' }, icon(ICONS.live));
    options(this.kind, Object.entries(KINDS), 'livelink');
    const row = (label: string, control: HTMLElement): HTMLElement => make('div', { class: 'field' }, make('label', { for: control.id }, label), control);
    const form = make('form', {}, make('h2', {}, 'Send live'),
      make('p', { class: 'help' }, 'An engine on this machine or in your network shows what this page shows: playing, standing, and every edit as you make it. The sound stays here.'),
      row('Receiver', this.kind), row('Address', this.to), this.help, row('Name of the subject', this.subject), this.told,
      make('div', { class: 'actions' }, button('Close', () => this.dialog.close()), this.go));
    this.dialog = make('dialog', { class: 'help-dialog live-dialog', 'aria-label': 'Send live' }, form);
    form.addEventListener('submit', (event) => { event.preventDefault(); void this.start(); });
    this.kind.addEventListener('change', () => this.tell());
    for (const name of ['state', 'time'] as const) playback.on(name, () => { if (name === 'state' || !playback.playing) this.touch(); });
    session.on('take', ({ take }) => { if (take.take !== 'beginning') this.touch(); });
    void api.live().then((now) => this.show(now)).catch(() => undefined);
    this.tell();
  }

  private tell(): void {
    const port = this.kind.value === 'livelink' ? 11111 : 39539;
    this.help.textContent = `A name or number, with :PORT if it is not ${port}.`;
    (this.subject.closest('.field') as HTMLElement).hidden = this.kind.value !== 'livelink';
  }

  private shows(): api.PageShows | undefined {
    const { playback: { now, playing, speed, loop }, session: { take } } = this;
    return take === undefined || take.take === 'beginning' ? undefined : { take: take.take, at: now, speed: playing ? speed : 0, loop };
  }

  private async start(): Promise<void> {
    const shown = this.shows();
    this.told.hidden = true;
    try {
      if (shown === undefined) throw new Error('Perform a line first: there is nothing to send yet.');
      this.show(await api.startLive({ ...shown, kind: this.kind.value, to: this.to.value, subject: this.subject.value }));
      this.dialog.close();
    } catch (problem) {
      this.told.textContent = problem instanceof Error ? problem.message : String(problem);
      this.told.hidden = false;
    }
  }

  private async stop(): Promise<void> {
    await api.stopLive().then((now) => this.show(now)).catch((problem: unknown) => this.session.tell(problem));
  }

  private show({ sending, kind = '', to = '' }: api.Live): void {
    this.sending = sending;
    this.element.setAttribute('aria-pressed', String(sending));
    this.element.title = sending ? `Sending to ${to} (${KINDS[kind] ?? kind}); press to stop` : 'Send live to an engine: Unreal, a VRM avatar';
    this.element.setAttribute('aria-label', sending ? `Stop sending to ${to}` : 'Send live to an engine');
    if (sending) this.touch();
  }

  /** Says what is shown, a little later and once for many calls. */
  private touch(): void {
    if (!this.sending || this.waiting !== 0) return;
    this.waiting = window.setTimeout(() => {
      this.waiting = 0;
      const shown = this.shows();
      if (shown !== undefined) void api.showLive(shown).catch(() => undefined); // the next change says it again
    }, SCRUB_MS);
  }
}
