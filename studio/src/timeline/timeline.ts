// The timeline: ruler, sound, words, phones, emotions and chosen channels over one window of time.
import type { MotionClip } from 'mien-viewer';
import { PAUSES } from '../anchors';
import type { Point } from '../curves';
import { intensityAt } from '../curves';
import { button, icon, ICONS, make } from '../dom';
import {
  bordersOf, borderEdit, borderRoom, channelEdit, intensityEdit, intensityOf, moveBorder, pointsOf, setChannel, setIntensity,
  type Border,
} from '../layer';
import type { Playback } from '../playback';
import type { Session } from '../session';
import type { Blend, Layer } from '../types';
import { ChannelMenu } from './channel_menu';
import { Handles, type HandleFacts } from './handles';
import { Lane } from './lane';
import { paintChannel, paintIntensity, paintRuler, paintSpans, Waveform } from './paint';
import { TimeWindow } from './window';

const FIRST_CHANNELS = ['jawOpen', 'mouthSmileLeft', 'browInnerUp'];
const PLACED = 1e-3; // s: two points of a curve never stand nearer

interface Row { lane: Lane; handles?: Handles; refresh?: () => void }

export class Timeline {
  readonly element = make('section', { id: 'timeline', 'aria-label': 'Timeline' });
  readonly window = new TimeWindow();
  private readonly lanes = make('div', { class: 'lanes' });
  private readonly playhead = make('div', { class: 'playhead', 'aria-hidden': 'true' });
  private readonly rows: Row[] = [];
  private readonly fixed: Row[];
  private readonly made = new Map<string, Row>();
  private wave: Waveform | undefined;
  private clip: MotionClip | undefined;
  private readonly channels: ChannelMenu;
  private emotions: string[] = [];
  private shown: Layer;
  private readonly emotionChoice = make('select', { 'aria-label': 'Add an emotion', class: 'small' });
  private waiting = false;
  private border: { place: number; at: number } | undefined;

  constructor(private readonly session: Session, private readonly playback: Playback) {
    this.shown = session.layer;
    this.channels = new ChannelMenu(session.about.channels, FIRST_CHANNELS, () => this.rebuild());
    this.fixed = [this.ruler(), this.sound(), this.words(), this.phones()];
    this.emotionChoice.addEventListener('change', () => this.addEmotion());
    this.element.append(this.lanes, this.playhead);
    this.listen();
    this.rebuild();
  }

  // ------------------------------------------------------------ what changes

  private listen(): void {
    const { session, playback } = this;
    session.on('take', ({ take, fresh }) => {
      this.shown = session.layer;
      if (fresh) {
        this.window.setTotal(take.seconds);
        this.emotions = [...new Set(take.emotions.map(({ name }) => name).filter((name) => name !== 'neutral'))];
        this.rebuild();
      }
      this.redraw();
    });
    session.on('frames', (clip) => { this.clip = clip; this.redraw(); });
    session.on('layer', (layer) => { this.shown = layer; this.keepEmotions(layer); });
    playback.on('time', (seconds) => this.moveHead(seconds));
    playback.on('state', () => this.redraw());
    this.window.on('change', () => { this.redraw(); this.moveHead(playback.now); });
    new ResizeObserver(() => {
      this.window.setWidth(this.fixed[0]?.lane.body.clientWidth ?? 0);
      this.redraw();
      this.moveHead(playback.now);
    }).observe(this.element);
    this.lanes.addEventListener('wheel', (event) => this.wheel(event), { passive: false });
    matchMedia('(prefers-color-scheme: light)').addEventListener('change', () => this.redraw());
  }

  setSound(samples: Float32Array, rate: number): void {
    this.wave = new Waveform(samples, rate);
    this.redraw();
  }

  private keepEmotions(layer: Layer): void {
    const edited = layer.edits.flatMap((edit) => (edit.kind === 'intensity' ? [edit.emotion] : []));
    const missing = edited.filter((name) => !this.emotions.includes(name));
    this.emotions.push(...missing);
    if (missing.length > 0) this.rebuild();
    this.redraw();
  }

  private addEmotion(): void {
    const name = this.emotionChoice.value;
    if (name === '' || this.emotions.includes(name)) return;
    this.emotions.push(name);
    this.rebuild();
    const { seconds } = this.playback;
    const flat: Point[] = [[0, 0.5], [seconds, 0.5]];
    this.session.commit(setIntensity(this.session.layer, name, flat, this.session.speech));
  }

  private wheel(event: WheelEvent): void {
    if (event.ctrlKey || event.metaKey) {
      event.preventDefault();
      const x = event.clientX - (this.fixed[0]?.lane.body.getBoundingClientRect().left ?? 0);
      this.window.zoom(Math.exp(event.deltaY * 0.0025), this.window.seconds(x));
    } else if (event.shiftKey || Math.abs(event.deltaX) > Math.abs(event.deltaY)) {
      event.preventDefault();
      this.window.pan(((event.deltaX || event.deltaY) / this.window.width) * this.window.span);
    }
  }

  private moveHead(seconds: number): void {
    if (this.playback.playing) this.window.follow(seconds);
    const left = this.fixed[0]?.lane.body.offsetLeft ?? 0;
    this.playhead.style.transform = `translateX(${left + this.window.x(seconds)}px)`;
    this.playhead.hidden = !this.window.holds(seconds, 1e-6);
  }

  /** All lanes in their order. */
  private rebuild(): void {
    const made = (kind: string, name: string): Row => {
      const key = `${kind} ${name}`;
      const row = this.made.get(key) ?? (kind === 'emotion' ? this.emotion(name) : this.channel(name));
      this.made.set(key, row);
      return row;
    };
    this.rows.splice(0, this.rows.length, ...this.fixed, ...this.emotions.map((name) => made('emotion', name)),
      ...this.channels.chosen.map((name) => made('channel', name)));
    const fresh = this.session.about.emotions.filter((name) => name !== 'neutral' && !this.emotions.includes(name));
    this.emotionChoice.replaceChildren(make('option', { value: '' }, '+ emotion'), ...fresh.map((name) => make('option', { value: name }, name)));
    this.emotionChoice.hidden = fresh.length === 0;
    const add = make('div', { class: 'lane add' }, make('div', { class: 'head wide' }, this.emotionChoice, this.channels.element));
    this.lanes.replaceChildren(...this.rows.map(({ lane }) => lane.element), add);
    this.redraw();
  }

  private redraw(): void {
    if (this.waiting) return;
    this.waiting = true;
    requestAnimationFrame(() => {
      this.waiting = false;
      this.window.setWidth(this.fixed[0]?.lane.body.clientWidth ?? 0);
      for (const { lane, handles, refresh } of this.rows) {
        refresh?.();
        handles?.place();
        lane.draw();
      }
    });
  }

  // ------------------------------------------------------------ lanes

  private ruler(): Row {
    const lane = new Lane('Time', 'ruler', this.window, (brush) => paintRuler(brush, this.playback.loop), 'seconds',
      button('Wider', () => this.window.zoom(1.6, this.middle()), { class: 'small', title: 'See more of the line (-)' }, icon(ICONS.minus)),
      button('Closer', () => this.window.zoom(1 / 1.6, this.middle()), { class: 'small', title: 'See it closer (+)' }, icon(ICONS.plus)),
      button('Whole line', () => this.window.fit(), { class: 'small', title: 'Whole line (0)' }, icon(ICONS.fit)));
    const handles = new Handles(lane.layer, this.window, {
      drag: ({ key }, at) => this.moveLoop(key, at),
      drop: ({ key }, at) => this.moveLoop(key, at),
      remove: () => this.playback.setLoop(null),
    }, () => 1 / this.playback.fps);
    const refresh = (): void => handles.set((this.playback.loop ?? []).map((at, end) => ({
      key: end === 0 ? 'loop-start' : 'loop-end', at, label: end === 0 ? 'Loop start' : 'Loop end', text: `${at.toFixed(3)} s`,
      range: [0, this.playback.seconds] as [number, number],
    })));
    this.draggable(lane.body, (from, to) => this.playback.setLoop(Math.abs(to - from) > 0.02 ? [Math.min(from, to), Math.max(from, to)] : null));
    return { lane, handles, refresh };
  }

  /** What zooming keeps in place: the playhead where it is seen, else the middle. */
  private middle(): number {
    const { window, playback } = this;
    return window.holds(playback.now) ? playback.now : (window.first + window.last) / 2;
  }

  private moveLoop(key: string, at: number): void {
    const [first, last] = this.playback.loop ?? [0, 0];
    this.playback.setLoop(key === 'loop-start' ? [Math.min(at, last - 0.03), last] : [first, Math.max(at, first + 0.03)]);
  }

  private sound(): Row {
    const lane = new Lane('Sound', 'wave', this.window, (brush) => this.wave?.paint(brush), 'sound');
    this.scrubbable(lane.body);
    return { lane };
  }

  private words(): Row {
    const lane = new Lane('Words', 'words', this.window, (brush) => paintSpans(brush, this.session.take?.words ?? [], 'word'), 'words');
    this.scrubbable(lane.body);
    lane.body.addEventListener('dblclick', (event) => {
      const at = this.secondsAt(event);
      const word = this.session.take?.words.find(([begin, end]) => at >= begin && at < end);
      if (word !== undefined) this.playback.setLoop([word[0], word[1]]);
    });
    return { lane };
  }

  private phones(): Row {
    const lane = new Lane('Phones', 'phones', this.window, (brush) => paintSpans(brush, this.phonesShown(), 'phone'), 'phones');
    const find = (key: string): Border | undefined => this.borders().find(({ place }) => `border-${place}` === key);
    const handles = new Handles(lane.layer, this.window, {
      drag: ({ key }, at) => {
        const border = find(key);
        if (border === undefined) return;
        this.border = { place: border.place, at };
        this.session.showBorder(border.place, at);
      },
      drop: ({ key }, at) => {
        const border = find(key);
        this.border = undefined;
        if (border !== undefined) this.session.commit(moveBorder(this.session.layer, border, at - border.at));
      },
      reset: ({ key }) => {
        const border = find(key);
        const edit = border && borderEdit(this.session.layer, border);
        if (border !== undefined && edit !== undefined) this.session.commit(moveBorder(this.session.layer, border, -edit.shift));
      },
    }, () => 1 / this.playback.fps);
    this.scrubbable(lane.body);
    return { lane, handles, refresh: () => handles.set(this.borders().map((border) => this.borderHandle(border))) };
  }

  private borders(): Border[] { return bordersOf(this.session.speech); }

  private borderHandle(border: Border): HandleFacts {
    const { phones } = this.session.speech;
    const name = (place: number): string => (PAUSES.has(phones[place]?.[2] ?? '') ? 'pause' : phones[place]?.[2] ?? '');
    return {
      key: `border-${border.place}`, at: border.at, range: borderRoom(phones, border.place),
      label: `Border between ${name(border.place)} and ${name(border.place + 1)} in ${border.phone.word}`,
      text: `${border.at.toFixed(3)} s`, edited: borderEdit(this.shown, border) !== undefined,
    };
  }

  private phonesShown() {
    const { phones } = this.session.speech;
    const { border } = this;
    if (border === undefined) return phones;
    return phones.map(([begin, end, label], place): [number, number, string] => [
      place === border.place + 1 ? border.at : begin, place === border.place ? border.at : end, label]);
  }

  /** Points of a curve as handles that may be dragged, added and removed. */
  private curve(
    lane: Lane, name: string, get: () => { points: Point[]; edited: boolean }, show: (points: Point[]) => void, keep: (points: Point[]) => void,
    scale: { to: (value: number) => number; from: (share: number) => number; text: (value: number) => string },
  ): Row {
    const changed = (key: string, at: number, share: number): Point[] => {
      const points = [...get().points];
      const place = Number(key.split('-')[1]);
      const [before, after] = [points[place - 1]?.[0] ?? -Infinity, points[place + 1]?.[0] ?? Infinity];
      points[place] = [Math.min(Math.max(at, before + PLACED), after - PLACED), scale.from(share)];
      return points;
    };
    const handles = new Handles(lane.layer, this.window, {
      drag: ({ key }, at, share) => show(changed(key, at, share)),
      drop: ({ key }, at, share) => keep(changed(key, at, share)),
      remove: ({ key }) => keep(get().points.filter((_, place) => `point-${place}` !== key)),
    }, () => 1 / this.playback.fps);
    lane.body.addEventListener('dblclick', (event) => {
      const area = lane.layer.getBoundingClientRect();
      const share = Math.min(Math.max(1 - (event.clientY - area.top) / area.height, 0), 1);
      keep([...get().points, [this.secondsAt(event), scale.from(share)]]);
    });
    const refresh = (): void => {
      if (handles.dragging !== undefined) return;
      const { points, edited } = get();
      handles.set(points.map(([at, value], place) => ({
        key: `point-${place}`, at, value: scale.to(value), edited, range: [0, this.playback.seconds],
        label: `${name}, point ${place + 1} of ${points.length}`, text: `${scale.text(value)} at ${at.toFixed(2)} s`,
      })));
    };
    return { lane, handles, refresh };
  }

  private emotion(name: string): Row {
    let dragged: Point[] | undefined;
    const now = (): { points: Point[]; blend: Blend } => {
      const { session } = this;
      return intensityOf(this.shown, session.take?.emotions.find((emotion) => emotion.name === name), name, session.speech);
    };
    const lane = new Lane(`${name} intensity`, 'emotion', this.window, (brush) => paintIntensity(brush, dragged ?? now().points, now().blend), name,
      this.plus(`Add a point to ${name} at the playhead`, () => {
        const { points, blend } = now();
        const at = this.playback.now;
        keep([...points, [at, points.length === 0 ? 0.5 : intensityAt(points, at, blend)]]);
      }),
      button(`Reset ${name}`, () => this.session.commit(setIntensity(this.session.layer, name, [], this.session.speech)), { class: 'small reset' }, icon(ICONS.undo)));
    const keep = (points: Point[]): void => {
      dragged = undefined;
      this.session.commit(setIntensity(this.session.layer, name, apart(points), this.session.speech, now().blend));
    };
    const show = (points: Point[]): void => {
      dragged = points;
      void this.session.showIntensity(now(), { points, blend: now().blend });
      this.redraw();
    };
    const row = this.curve(lane, `${name} intensity`, () => ({ points: now().points, edited: intensityEdit(this.shown, name) !== undefined }),
      show, keep, { to: (value) => value, from: (share) => Math.round(share * 100) / 100, text: (value) => `${Math.round(value * 100)} %` });
    lane.head.title = 'Double-click the lane to add a point';
    return { ...row, refresh: () => {
      lane.element.classList.toggle('edited', intensityEdit(this.shown, name) !== undefined);
      row.refresh?.();
    } };
  }

  private channel(name: string): Row {
    const { session } = this;
    const facts = session.facts.get(name);
    const [minimum, maximum] = [facts?.minimum ?? 0, facts?.maximum ?? 1];
    const unit = facts?.unit === 'degrees' ? '°' : '';
    const get = (): { points: Point[]; edited: boolean } => {
      const edit = channelEdit(this.shown, name);
      return { points: edit === undefined ? [] : pointsOf(edit.keys, session.speech), edited: edit !== undefined };
    };
    const changed = (points: Point[]): Layer =>
      setChannel(session.layer, name, apart(points), session.speech, channelEdit(session.layer, name)?.mode ?? 'replace');
    const lane = new Lane(name, 'channel', this.window, (brush) => {
      if (this.clip !== undefined) paintChannel(brush, this.clip, name, [minimum, maximum]);
    }, name,
      this.plus(`Add a key to ${name} at the playhead`, () => {
        const at = this.playback.now;
        const column = this.clip?.channels.indexOf(name) ?? -1;
        if (column >= 0) keep([...get().points, [at, this.clip?.sample(at)[column] ?? 0]]);
      }),
      button(`Reset ${name}`, () => session.commit(setChannel(session.layer, name, [], session.speech, 'replace')), { class: 'small reset' }, icon(ICONS.undo)),
      button(`Hide ${name}`, () => this.channels.toggle(name, false), { class: 'small' }, icon(ICONS.cross)));
    const keep = (points: Point[]): void => session.commit(changed(points));
    const row = this.curve(lane, name, get, (points) => session.show(changed(points)), keep, {
      to: (value) => (value - minimum) / (maximum - minimum), from: (share) => minimum + share * (maximum - minimum),
      text: (value) => `${unit === '' ? value.toFixed(2) : value.toFixed(1)}${unit}`,
    });
    lane.head.title = 'Double-click the lane to add a key';
    return { ...row, refresh: () => {
      lane.element.classList.toggle('edited', channelEdit(this.shown, name) !== undefined);
      row.refresh?.();
    } };
  }

  private plus(label: string, press: () => void): HTMLButtonElement {
    return button(label, press, { class: 'small' }, icon(ICONS.plus));
  }

  // ------------------------------------------------------------ pointer

  private secondsAt(event: MouseEvent): number {
    const left = this.fixed[0]?.lane.body.getBoundingClientRect().left ?? 0;
    return Math.min(Math.max(this.window.seconds(event.clientX - left), 0), this.playback.seconds);
  }

  private scrubbable(body: HTMLElement): void {
    body.addEventListener('pointerdown', (event) => {
      if (event.button !== 0) return;
      const again = this.playback.playing;
      this.playback.pause();
      this.playback.seek(this.secondsAt(event));
      body.setPointerCapture(event.pointerId);
      const move = (to: PointerEvent): void => this.playback.seek(this.secondsAt(to));
      body.addEventListener('pointermove', move);
      const end = (): void => {
        body.removeEventListener('pointermove', move);
        if (again) void this.playback.play();
      };
      body.addEventListener('pointerup', end, { once: true });
      body.addEventListener('pointercancel', end, { once: true });
    });
  }

  /** A click seeks, a drag chooses a region. */
  private draggable(body: HTMLElement, choose: (from: number, to: number) => void): void {
    body.addEventListener('pointerdown', (event) => {
      if (event.button !== 0) return;
      const from = this.secondsAt(event);
      let far = false;
      body.setPointerCapture(event.pointerId);
      const move = (to: PointerEvent): void => {
        far ||= Math.abs(to.clientX - event.clientX) > 4;
        if (far) choose(from, this.secondsAt(to));
      };
      body.addEventListener('pointermove', move);
      body.addEventListener('pointerup', () => {
        body.removeEventListener('pointermove', move);
        if (!far) this.playback.seek(from);
      }, { once: true });
    });
  }
}

/** Points in order, no two at one moment. */
function apart(points: readonly Point[]): Point[] {
  const sorted = [...points].sort((a, b) => a[0] - b[0]);
  return sorted.filter(([at], place) => place === 0 || at - (sorted[place - 1] as Point)[0] >= PLACED / 2);
}
