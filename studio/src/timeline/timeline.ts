// The timeline: ruler, sound, words, phones, emotions and chosen channels over one window of time.
import type { MotionClip } from 'mien-viewer';
import { PAUSES } from '../anchors';
import type { Point } from '../curves';
import { intensityAt, tangentAt } from '../curves';
import { button, icon, ICONS, make } from '../dom';
import { closeMenu, showMenu, type Item } from './context_menu';
import {
  bordersOf, borderEdit, borderRoom, channelEdit, intensityEdit, intensityOf, moveBorder, pointsOf, setChannel, setIntensity,
  type Border,
} from '../layer';
import type { Playback } from '../playback';
import type { Session } from '../session';
import type { Blend, Layer, Tangent } from '../types';
import { ChannelMenu } from './channel_menu';
import { mirrored, offset, pasted, pointOf, scaled, Selection, tidy, without, withTangent, type Marked } from './selection';
import { SpeechMenu } from './speech_menu';
import { Spectrogram } from './spectrogram';
import { Handles, type HandleFacts } from './handles';
import { Lane } from './lane';
import { paintChannel, paintIntensity, paintRuler, paintSpans, Waveform } from './paint';
import { TimeWindow } from './window';

const FIRST_CHANNELS = ['jawOpen', 'mouthSmileLeft', 'browInnerUp'];
const NEAR = 0.05; // s: so far a key is drawn to a border
/** Tangents, what they do, and the interpolation of a whole curve that does the same at every key. */
const TANGENTS: readonly (readonly [Tangent, string, Blend])[] = [['auto', 'smooth, without overshoot', 'spline'], ['flat', 'level at the key', 'smooth'], ['linear', 'straight to the next key', 'linear'], ['step', 'stays until the next key', 'hold']];

/** A lane whose keys can be changed. */
interface Curve {
  name: string; lane: Lane; handles: Handles;
  points: () => Point[];
  changed: (layer: Layer, points: readonly Point[]) => Layer;
  show: (points: Point[]) => void;
  blend: () => Blend;
  setBlend: (blend: Blend) => void;
  /** The values that the lane shows, and those that are allowed. */
  range: [number, number]; whole: [number, number];
}
interface Row { lane: Lane; handles?: Handles; refresh?: () => void; curve?: Curve }
export interface TimelineState { view: { first: number; last: number; at: number; loop: [number, number] | null }; channels: string[]; tall: string[]; markers: Record<string, number[]>; snap: string }

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
  readonly selection = new Selection();
  /** Called with the moment while the playhead is dragged. */
  scrubbed: (at: number) => void = () => undefined;
  /** Called when something has changed that is kept with the page. */
  changed: () => void = () => undefined;
  private copied = new Map<string, Point[]>();
  private markers: Record<string, number[]> = {};
  private other: MotionClip | undefined;
  private samples: { values: Float32Array; rate: number } | undefined;
  private spectrogram: Spectrogram | undefined;
  private readonly tall = new Set<string>();
  private readonly hidden = new Set<string>();
  private readonly snap = make('select', { 'aria-label': 'Keys snap to', class: 'small', title: 'What dragged keys are drawn to' });

  constructor(private readonly session: Session, private readonly playback: Playback) {
    this.shown = session.layer;
    this.channels = new ChannelMenu(session.about.channels, FIRST_CHANNELS, () => this.rebuild());
    this.fixed = [this.ruler(), this.sound(), this.words(), this.phones()];
    this.emotionChoice.addEventListener('change', () => this.addEmotion());
    for (const name of ['nothing', 'frames', 'phones', 'words']) this.snap.append(make('option', { value: name }, `snap: ${name}`));
    this.snap.addEventListener('change', () => this.changed());
    this.element.append(this.lanes, this.playhead);
    this.listen();
    this.rebuild();
  }

  // ------------------------------------------------------------ what changes

  private listen(): void {
    const { session, playback } = this;
    session.on('take', ({ take, fresh, other }) => {
      this.shown = session.layer;
      if (fresh) {
        if (other) {
          this.selection.clear();
          this.hidden.clear();
        }
        this.window.setTotal(take.seconds, !other);
        this.keepEmotions(session.layer);
      }
      this.redraw();
    });
    this.selection.on('change', () => this.redraw());
    session.on('frames', (clip) => { this.clip = clip; this.redraw(); });
    session.on('layer', (layer) => {
      this.shown = layer;
      for (const edit of layer.edits) if (edit.kind === 'channel') this.channels.toggle(edit.channel, true);
      this.keepEmotions(layer);
    });
    playback.on('time', (seconds) => this.moveHead(seconds));
    playback.on('state', () => this.redraw());
    this.window.on('change', () => { this.redraw(); this.moveHead(playback.now); });
    new ResizeObserver(() => {
      this.window.setWidth(this.fixed[0]?.lane.body.clientWidth ?? 0);
      this.redraw();
      this.moveHead(playback.now);
    }).observe(this.element);
    this.lanes.addEventListener('wheel', (event) => this.wheel(event), { passive: false });
    this.lanes.addEventListener('scroll', () => closeMenu());
    this.lanes.addEventListener('pointerdown', (event) => { if (event.button === 1) this.pan(event); }, { capture: true });
    this.lanes.addEventListener('pointerdown', (event) => { // below the lanes
      if ((event.target as HTMLElement).closest('.lane, button, select, details') === null) this.marquee(event);
    });
    this.lanes.addEventListener('contextmenu', (event) => this.menu(event));
    this.lanes.addEventListener('pointermove', (event) => this.nameUnder(event));
    matchMedia('(prefers-color-scheme: light)').addEventListener('change', () => this.redraw());
  }

  setSound(samples: Float32Array, rate: number): void {
    this.wave = new Waveform(samples, rate);
    this.samples = { values: samples, rate };
    if (this.spectrogram !== undefined) this.spectrogram = new Spectrogram(samples, rate);
    this.redraw();
  }

  /** The curves of another take, under those of this one. */
  setOther(clip: MotionClip | undefined): void {
    this.other = clip;
    this.redraw();
  }

  state(): TimelineState {
    const { window: { first, last }, playback } = this;
    return { view: { first, last, at: playback.now, loop: playback.loop }, channels: this.channels.chosen, tall: [...this.tall], markers: this.markers, snap: this.snap.value };
  }

  restore(before: Partial<TimelineState>): void {
    if (before.channels !== undefined) this.channels.choose(before.channels);
    if (before.markers !== undefined) this.markers = before.markers;
    if (before.snap !== undefined) this.snap.value = before.snap;
    for (const name of before.tall ?? []) this.tall.add(name);
    if (before.view !== undefined && this.session.take !== undefined) {
      this.window.show(before.view.first, before.view.last);
      this.playback.seek(before.view.at);
      this.playback.setLoop(before.view.loop);
    }
    this.rebuild();
  }

  private keepEmotions(layer: Layer): void {
    const asked = this.session.take?.emotions.map(({ name }) => name) ?? [];
    const edited = layer.edits.flatMap((edit) => (edit.kind === 'intensity' ? [edit.emotion] : []));
    const wanted = [...new Set([...asked, ...edited])].filter((name) => name !== 'neutral' && !this.hidden.has(name));
    if (wanted.join() !== this.emotions.join()) {
      this.emotions = wanted;
      this.rebuild();
    }
    this.redraw();
  }

  /** Takes an emotion away: out of what the take was asked for, out of the edits, or, where the text asks for it, by a curve at 0. */
  private removeEmotion(name: string): void {
    const { session } = this;
    const asked = ([] as string[]).concat(session.request.emotion ?? []);
    const left = asked.filter((one) => one.split(/[:[]/)[0] !== name);
    const layer = setIntensity(session.layer, name, [], session.speech);
    const inText = (session.request.text ?? '').includes(`<${name}`) || (session.request.text ?? '').includes(`"${name}"`);
    if (left.length < asked.length) void session.perform({ emotion: left, layer });
    else if (inText) session.commit(setIntensity(session.layer, name, [[0, 0], [this.playback.seconds, 0]], session.speech));
    else session.commit(layer);
  }

  private addEmotion(): void {
    const name = this.emotionChoice.value;
    if (name === '' || this.emotions.includes(name)) return;
    this.hidden.delete(name);
    const { seconds } = this.playback;
    const flat: Point[] = [[0, 0.5], [seconds, 0.5]];
    this.session.commit(setIntensity(this.session.layer, name, flat, this.session.speech));
  }

  private wheel(event: WheelEvent): void {
    if (event.altKey && !event.ctrlKey) {
      const row = this.rows.find(({ lane }) => lane.body.contains(event.target as Node));
      if (row?.curve === undefined) return;
      event.preventDefault();
      const area = row.lane.layer.getBoundingClientRect();
      this.zoomValues(row.curve, Math.exp(event.deltaY * 0.0025), 1 - (event.clientY - area.top) / area.height);
      return;
    }
    if (event.ctrlKey || event.metaKey) {
      event.preventDefault();
      const x = event.clientX - (this.fixed[0]?.lane.body.getBoundingClientRect().left ?? 0);
      this.window.zoom(Math.exp(event.deltaY * 0.0025), this.window.seconds(x));
    } else if (event.shiftKey || Math.abs(event.deltaX) > Math.abs(event.deltaY)) {
      event.preventDefault();
      this.window.pan(((event.deltaX || event.deltaY) / this.window.width) * this.window.span);
    }
  }

  /** Shows fewer or more values of a lane, about a share of its height. */
  private zoomValues(curve: Curve, factor: number, about: number): void {
    const [low, high] = curve.range;
    const [least, most] = curve.whole;
    const span = Math.min(Math.max((high - low) * factor, (most - least) / 50), most - least);
    const from = Math.min(Math.max(low + about * (high - low) - about * span, least), most - span);
    curve.range = [from, from + span];
    this.redraw();
  }

  /** Drags the window of time, and the lanes up and down. */
  private pan(event: PointerEvent): void {
    event.preventDefault();
    const [x, y, first, top] = [event.clientX, event.clientY, this.window.first, this.lanes.scrollTop];
    const move = (to: PointerEvent): void => {
      this.window.show(first - ((to.clientX - x) / this.window.width) * this.window.span, first - ((to.clientX - x) / this.window.width) * this.window.span + this.window.span);
      this.lanes.scrollTop = top - (to.clientY - y);
    };
    globalThis.addEventListener('pointermove', move);
    globalThis.addEventListener('pointerup', () => globalThis.removeEventListener('pointermove', move), { once: true });
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
    for (const { lane } of this.rows) lane.element.classList.toggle('tall', this.tall.has(lane.name));
    const add = make('div', { class: 'lane add' }, make('div', { class: 'head wide' }, this.emotionChoice, this.channels.element, this.snap));
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
    const moved = ({ key }: HandleFacts, at: number): void => (key.startsWith('marker') ? this.moveMarker(key, at) : this.moveLoop(key, at));
    const handles = new Handles(lane.layer, this.window, {
      drag: moved, drop: moved,
      remove: ({ key }) => { if (key.startsWith('marker')) this.moveMarker(key, undefined); else this.playback.setLoop(null); },
    }, () => 1 / this.playback.fps);
    const refresh = (): void => {
      if (handles.dragging !== undefined) return;
      const range: [number, number] = [0, this.playback.seconds];
      const loop = (this.playback.loop ?? []).map((at, end) => ({ key: end === 0 ? 'loop-start' : 'loop-end', at, label: end === 0 ? 'Loop start' : 'Loop end', text: `${at.toFixed(3)} s`, range }));
      handles.set([...loop, ...this.marked.map((at, place) => ({ key: `marker-${place}`, at, label: `Marker ${place + 1}`, text: `${at.toFixed(3)} s`, range, edited: true }))]);
    };
    this.draggable(lane.body, (from, to) => this.playback.setLoop(Math.abs(to - from) > 0.02 ? [Math.min(from, to), Math.max(from, to)] : null));
    return { lane, handles, refresh };
  }

  private get marked(): number[] { return this.markers[this.session.take?.take ?? ''] ?? []; }

  private moveMarker(key: string, at: number | undefined): void {
    const id = this.session.take?.take;
    if (id === undefined) return;
    const marked = [...this.marked];
    marked.splice(Number(key.split('-')[1]), 1, ...(at === undefined ? [] : [at]));
    this.markers = { ...this.markers, [id]: marked };
    this.changed();
    this.redraw();
  }

  /** Puts a marker at the playhead. */
  addMarker(): void {
    const id = this.session.take?.take;
    if (id === undefined) return;
    this.markers = { ...this.markers, [id]: [...this.marked, this.playback.now] };
    this.changed();
    this.redraw();
  }

  /** The next marker before or after the playhead. */
  toMarker(step: 1 | -1): void {
    const { now } = this.playback;
    const found = this.marked.filter((at) => (at - now) * step > 1e-3).sort((a, b) => (a - b) * step)[0];
    if (found !== undefined) this.playback.seek(found);
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
    const toggle = button('Spectrogram', () => {
      this.spectrogram = this.spectrogram === undefined && this.samples !== undefined ? new Spectrogram(this.samples.values, this.samples.rate) : undefined;
      toggle.setAttribute('aria-pressed', String(this.spectrogram !== undefined));
      lane.element.classList.toggle('tall', this.spectrogram !== undefined);
      this.redraw();
    }, { class: 'small', 'aria-pressed': 'false', title: 'Show the spectrogram instead of the wave' }, icon(ICONS.spectrum));
    const lane: Lane = new Lane('Sound', 'wave', this.window, (brush) => (this.spectrogram ?? this.wave)?.paint(brush, this.playback.seconds), 'sound', toggle);
    this.scrubbable(lane.body);
    return { lane };
  }

  private words(): Row {
    const lane = new Lane('Words', 'words', this.window, (brush) => paintSpans(brush, this.session.take?.words ?? [], 'word'), 'words');
    this.scrubbable(lane.body);
    lane.element.tabIndex = 0;
    lane.body.addEventListener('dblclick', (event) => {
      const at = this.secondsAt(event);
      const word = this.session.take?.words.find(([begin, end]) => at >= begin && at < end);
      if (word !== undefined) this.playback.setLoop([word[0], word[1]]);
    });
    return { lane };
  }

  private phones(): Row {
    const lane = new Lane('Phones', 'phones', this.window, (brush) => paintSpans(brush, this.phonesShown(), 'phone'), 'phones');
    lane.head.title = 'Double click a sound to correct it; the right button has more';
    lane.body.addEventListener('dblclick', (event) => {
      if ((event.target as HTMLElement).closest('.handle') === null) new SpeechMenu(this.session, 'phones', this.secondsAt(event), (loop) => this.playback.setLoop(loop)).correct();
    });
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

  // ------------------------------------------------------------ keys

  /** A lane of keys that may be dragged, chosen, added and removed. */
  private curve(lane: Lane, facts: Omit<Curve, 'lane' | 'handles'> & { edited: () => boolean; text: (value: number) => string }): Row {
    const { name, points } = facts;
    const to = (value: number): number => (value - curve.range[0]) / (curve.range[1] - curve.range[0]);
    const from = (share: number): number => curve.range[0] + share * (curve.range[1] - curve.range[0]);
    const place = (key: string): number => Number(key.split('-')[1]);
    const moved = (handle: HandleFacts, at: number, share: number): [number, number] => {
      const [was, value] = points()[place(handle.key)] ?? [at, from(share)];
      const level = Math.abs(share - (handle.value ?? share)) < 1e-9 ? value : from(share);
      return [this.snapped(at) - was, level - value];
    };
    const handles = new Handles(lane.layer, this.window, {
      choose: ({ key }, further) => {
        if (further) this.selection.toggle(name, place(key));
        else if (!this.selection.has(name, place(key))) this.selection.only(name, place(key));
      },
      drag: (handle, at, share) => { const [time, value] = moved(handle, at, share); this.apply((keys) => offset(keys, time, value), false); },
      drop: (handle, at, share) => { const [time, value] = moved(handle, at, share); this.apply((keys) => offset(keys, time, value)); },
      nudge: ({ key }, frames, share) => {
        if (!this.selection.has(name, place(key))) this.selection.only(name, place(key));
        const before = place(key);
        this.apply((keys, { range }) => offset(keys, frames / this.playback.fps, share * (range[1] - range[0])));
        if (!this.selection.has(name, before)) handles.focus(`point-${[...handles.keys.keys()].find((one) => this.selection.has(name, one)) ?? before}`);
      },
      remove: ({ key }) => {
        if (!this.selection.has(name, place(key))) this.selection.only(name, place(key));
        this.apply(without);
      },
    }, () => 1 / this.playback.fps);
    const curve: Curve = { ...facts, lane, handles };
    lane.body.addEventListener('dblclick', (event) => {
      const area = lane.layer.getBoundingClientRect();
      const share = Math.min(Math.max(1 - (event.clientY - area.top) / area.height, 0), 1);
      this.add(curve, this.snapped(this.secondsAt(event)), from(share));
    });
    lane.body.addEventListener('pointerdown', (event) => this.marquee(event));
    const refresh = (): void => {
      if (handles.dragging !== undefined) return;
      lane.element.classList.toggle('edited', facts.edited());
      const all = points();
      handles.set(all.map((point, number) => { const [at, value] = point; return {
        key: `point-${number}`, at, value: to(value), shape: tangentAt(point, facts.blend()), edited: facts.edited(), range: [0, this.playback.seconds], chosen: this.selection.has(name, number),
        label: `${name}, key ${number + 1} of ${all.length}`, text: `${facts.text(value)} at ${at.toFixed(2)} s`,
      }; }));
    };
    lane.head.append(button(`Taller or lower: ${name}`, () => {
      if (!this.tall.delete(lane.name)) this.tall.add(lane.name);
      lane.element.classList.toggle('tall', this.tall.has(lane.name));
      this.changed();
      this.redraw();
    }, { class: 'small', title: 'Taller or lower' }, icon(ICONS.tall)));
    return { lane, handles, refresh, curve };
  }

  private get curves(): Curve[] { return this.rows.flatMap(({ curve }) => (curve === undefined ? [] : [curve])); }

  private marks(curve: Curve): Marked[] {
    return curve.points().map(([at, value, tangent], place) => ({ at, value, tangent, chosen: this.selection.has(curve.name, place) }));
  }

  /** Changes the keys of lanes (those with chosen ones), as one step of undo; `keep` false only shows it. */
  private apply(change: (keys: Marked[], curve: Curve) => Marked[], keep = true, curves = this.curves.filter(({ name }) => this.selection.lanes.includes(name))): void {
    let { layer } = this.session;
    const chosen = new Map<string, Set<number>>();
    for (const curve of curves) {
      const keys = tidy(change(this.marks(curve), curve), this.playback.seconds, curve.whole);
      const points = keys.map(pointOf);
      layer = curve.changed(layer, points);
      chosen.set(curve.name, new Set(keys.flatMap((key, place) => (key.chosen ? [place] : []))));
      if (!keep && curves.length === 1) curve.show(points);
    }
    if (keep) {
      this.session.commit(layer);
      this.selection.set(chosen);
    } else if (curves.length > 1) this.session.show(layer);
    this.redraw();
  }

  private add(curve: Curve, at: number, value: number): void {
    this.apply((keys) => [...keys.map((key) => ({ ...key, chosen: false })), { at, value, chosen: true }], true, [curve]);
  }

  /** A moment drawn to what keys snap to. */
  private snapped(at: number): number {
    const { session, playback } = this;
    if (this.snap.value === 'frames') return Math.round(at * playback.fps) / playback.fps;
    const spans = this.snap.value === 'phones' ? session.speech.phones : this.snap.value === 'words' ? session.speech.words : [];
    const nearest = spans.flatMap(([begin, end]) => [begin, end]).sort((a, b) => Math.abs(a - at) - Math.abs(b - at))[0];
    return nearest !== undefined && Math.abs(nearest - at) < Math.max(NEAR, (8 / this.window.width) * this.window.span) ? nearest : at;
  }

  /** Chooses the keys in a rectangle over the lanes. */
  private marquee(event: PointerEvent): void {
    if (event.button !== 0 || (event.target as HTMLElement).closest('.handle') !== null) return;
    const area = this.lanes.getBoundingClientRect();
    const further = event.shiftKey || event.ctrlKey || event.metaKey;
    const before = new Map(further ? this.curves.map((curve): [string, Set<number>] => [curve.name, new Set(this.marks(curve).flatMap(({ chosen }, place) => (chosen ? [place] : [])))]) : []);
    const box = make('div', { class: 'marquee', 'aria-hidden': 'true' });
    this.element.append(box);
    const body = event.currentTarget as HTMLElement;
    body.setPointerCapture(event.pointerId);
    if (!further) this.selection.clear();
    const outer = this.element.getBoundingClientRect();
    const move = (to: PointerEvent): void => {
      const [left, right] = [Math.min(event.clientX, to.clientX), Math.max(event.clientX, to.clientX)];
      const [top, bottom] = [Math.max(Math.min(event.clientY, to.clientY), area.top), Math.max(event.clientY, to.clientY)];
      Object.assign(box.style, { left: `${left - outer.left}px`, top: `${top - outer.top}px`, width: `${right - left}px`, height: `${bottom - top}px` });
      const found = new Map(before);
      for (const { name, lane, points, range } of this.curves) {
        const inside = lane.layer.getBoundingClientRect();
        const set = new Set(before.get(name));
        points().forEach(([at, value], place) => {
          const x = inside.left + this.window.x(at);
          const y = inside.top + (1 - (value - range[0]) / (range[1] - range[0])) * inside.height;
          if (x >= left - 6 && x <= right + 6 && y >= top - 6 && y <= bottom + 6) set.add(place);
        });
        found.set(name, set);
      }
      this.selection.set(found);
    };
    body.addEventListener('pointermove', move);
    const end = (): void => {
      body.removeEventListener('pointermove', move);
      box.remove();
    };
    body.addEventListener('pointerup', end, { once: true });
    body.addEventListener('pointercancel', end, { once: true });
  }

  // ------------------------------------------------------------ what keys and the menu do

  selectAll(): void {
    this.selection.set(new Map(this.curves.map(({ name, points }) => [name, new Set(points().keys())])));
  }

  copy(cut = false): void {
    const chosen = this.curves.map((curve): [string, Point[]] => [curve.name, this.marks(curve).flatMap((key): Point[] => (key.chosen ? [pointOf(key)] : []))]).filter(([, points]) => points.length > 0);
    if (chosen.length === 0) return;
    const first = Math.min(...chosen.map(([, points]) => (points[0] as Point)[0]));
    this.copied = new Map(chosen.map(([name, points]) => [name, points.map(([at, ...rest]): Point => [at - first, ...rest])]));
    if (cut) this.apply(without);
  }

  /** Copied keys at the playhead; those of one lane alone go into the lane that is asked for. */
  paste(at = this.playback.now, into?: Curve): void {
    const only = this.copied.size === 1 ? [...this.copied.values()][0] : undefined;
    const targets = into !== undefined && only !== undefined ? [into] : this.curves.filter(({ name }) => this.copied.has(name));
    this.apply((keys, curve) => pasted(keys, only ?? this.copied.get(curve.name) ?? [], at), true, targets);
  }

  deleteChosen(): void { this.apply(without); }

  /** Values larger or smaller about 0, times about the first key. */
  scale(value: number, time = 1): void {
    const first = Math.min(...this.curves.flatMap((curve) => this.marks(curve).filter(({ chosen }) => chosen).map(({ at }) => at)));
    this.apply((keys) => scaled(keys, time, first, value));
  }

  /** The chosen keys onto the same channels of the other side of the face. */
  mirror(): void {
    const pairs = this.curves.flatMap((curve) => {
      const name = mirrored(curve.name);
      const points = this.marks(curve).flatMap((key): Point[] => (key.chosen ? [pointOf(key)] : []));
      return name === undefined || points.length === 0 || !this.session.facts.has(name) ? [] : [{ name, points }];
    });
    for (const { name } of pairs) this.channels.toggle(name, true);
    const targets = this.curves.filter(({ name }) => pairs.some((pair) => pair.name === name));
    this.apply((keys, { name }) => pasted(keys, pairs.find((pair) => pair.name === name)?.points ?? [], 0), true, targets);
  }

  private menu(event: MouseEvent): void {
    const row = this.rows.find(({ lane }) => lane.element.contains(event.target as Node));
    if (row === undefined || this.session.take === undefined) return;
    event.preventDefault();
    const key = (event.target as HTMLElement).closest<HTMLElement>('.handle')?.dataset['key'];
    const at = event.clientX === 0 && event.clientY === 0 ? this.playback.now : this.secondsAt(event);
    const corner = (event.target as HTMLElement).getBoundingClientRect();
    const [x, y] = event.clientX === 0 && event.clientY === 0 ? [corner.left + 20, corner.top + 10] : [event.clientX, event.clientY];
    showMenu(x, y, row.curve !== undefined ? this.keyItems(row.curve, key, at) : this.otherItems(row.lane, at));
  }

  private keyItems(curve: Curve, key: string | undefined, at: number): Item[] {
    const place = key === undefined ? -1 : Number(key.split('-')[1]);
    if (place >= 0 && !this.selection.has(curve.name, place)) this.selection.only(curve.name, place);
    const chosen = this.selection.size > 0;
    const item = (there: boolean, label: string, act: () => void, keys?: string): Item[] => (there ? [keys === undefined ? [label, act] : [label, act, keys]] : []);
    return [
      ...item(true, 'Add a key here', () => this.add(curve, this.snapped(at), this.valueAt(curve, at))),
      ...item(chosen, 'Copy', () => this.copy(), 'Ctrl+C'), ...item(chosen, 'Cut', () => this.copy(true), 'Ctrl+X'),
      ...item(this.copied.size > 0, 'Paste at the playhead', () => this.paste(this.playback.now, curve), 'Ctrl+V'),
      ...item(chosen, 'Delete', () => this.deleteChosen(), 'Del'), ...item(true, 'Choose all keys', () => this.selectAll(), 'Ctrl+A'),
      null,
      ...item(chosen, 'Values 10 % larger', () => this.scale(1.1), 'Alt+]'), ...item(chosen, 'Values 10 % smaller', () => this.scale(1 / 1.1), 'Alt+['),
      ...item(chosen, 'Slower (times 10 % apart)', () => this.scale(1, 1.1)), ...item(chosen, 'Faster (times 10 % nearer)', () => this.scale(1, 1 / 1.1)),
      ...item(chosen && mirrored(curve.name) !== undefined, 'Copy to the other side of the face', () => this.mirror()),
      null,
      ...this.tangentItems(curve, chosen),
      ...item(true, 'Fit the values', () => this.fitValues(curve)), ...item(curve.range[1] - curve.range[0] < curve.whole[1] - curve.whole[0], 'All values', () => { curve.range = [...curve.whole]; this.redraw(); }),
    ];
  }

  /** Tangents of the chosen keys, or of the whole curve where none is chosen. */
  private tangentItems(curve: Curve, chosen: boolean): Item[] {
    const keys = this.marks(curve);
    if (keys.length === 0) return [];
    const now = new Set(keys.filter((key) => key.chosen || !chosen).map((key) => tangentAt(pointOf(key), curve.blend())));
    return [{
      label: chosen ? 'Tangent of the chosen keys' : 'Tangents of the whole lane',
      choices: TANGENTS.map(([name, what, blend]) => ({
        name, title: what, pressed: now.size === 1 && now.has(name),
        act: () => { if (chosen) this.setTangent(name); else curve.setBlend(blend); },
      })),
    }, null];
  }

  /** How the curves pass the chosen keys. */
  setTangent(tangent: Tangent): void { this.apply((keys) => withTangent(keys, tangent)); }

  /** The next kind of tangent for the chosen keys. */
  nextTangent(): void {
    const [curve] = this.curves.filter(({ name }) => this.selection.lanes.includes(name));
    const key = curve === undefined ? undefined : this.marks(curve).find(({ chosen }) => chosen);
    if (curve === undefined || key === undefined) return;
    const now = TANGENTS.findIndex(([name]) => name === tangentAt(pointOf(key), curve.blend()));
    this.setTangent((TANGENTS[(now + 1) % TANGENTS.length] as typeof TANGENTS[number])[0]);
  }

  private valueAt(curve: Curve, at: number): number {
    const column = this.clip?.channels.indexOf(curve.name) ?? -1;
    return column >= 0 ? this.clip?.sample(at)[column] ?? 0 : curve.points().length === 0 ? 0.5 : intensityAt(curve.points(), at, curve.blend());
  }

  private fitValues(curve: Curve): void {
    const column = this.clip?.channels.indexOf(curve.name) ?? -1;
    const [low, high] = curve.whole;
    const values = column >= 0 && this.clip !== undefined ? Array.from({ length: this.clip.frames }, (_, frame) => this.clip?.values[frame * (this.clip?.channels.length ?? 0) + column] as number) : [];
    const seen = [...values, ...curve.points().map(([, value]) => value)];
    const [least, most] = [Math.min(...seen, high), Math.max(...seen, low)];
    const room = Math.max((most - least) * 0.1, (high - low) / 50);
    curve.range = [Math.max(least - room, low), Math.min(most + room, high)];
    this.redraw();
  }

  /** The whole name of a word or phone under the pointer: a narrow one has no room for it. */
  private nameUnder(event: PointerEvent): void {
    const lane = this.rows.find((row) => row.lane.body.contains(event.target as Node))?.lane;
    if (lane === undefined || (lane.kind !== 'words' && lane.kind !== 'phones')) return;
    const at = this.secondsAt(event);
    lane.body.title = this.session.take?.[lane.kind].find(([begin, end]) => at >= begin && at < end)?.[2] ?? '';
  }

  private otherItems(lane: Lane, at: number): Item[] {
    const { session, playback } = this;
    if (lane.kind === 'words' || lane.kind === 'phones') return new SpeechMenu(session, lane.kind, at, (loop) => playback.setLoop(loop)).items();
    return [['Put a marker here', () => { playback.seek(at); this.addMarker(); }, 'M'], ['Loop what is seen', () => playback.setLoop([Math.max(this.window.first, 0), Math.min(this.window.last, playback.seconds)])], ['No loop', () => playback.setLoop(null), 'L']];
  }

  private emotion(name: string): Row {
    let dragged: Point[] | undefined;
    const { session } = this;
    const now = (): { points: Point[]; blend: Blend } =>
      intensityOf(this.shown, session.take?.emotions.find((emotion) => emotion.name === name), name, session.speech);
    const lane: Lane = new Lane(`${name} intensity`, 'emotion', this.window, (brush) => paintIntensity(brush, dragged ?? now().points, now().blend, row.curve?.range ?? [0, 1]), name,
      this.plus(`Add a key to ${name} at the playhead`, () => {
        if (row.curve !== undefined) this.add(row.curve, this.playback.now, this.valueAt(row.curve, this.playback.now));
      }),
      button(`Reset ${name}`, () => session.commit(setIntensity(session.layer, name, [], session.speech)), { class: 'small reset' }, icon(ICONS.undo)),
      button(`Remove ${name}`, () => this.removeEmotion(name), { class: 'small' }, icon(ICONS.cross)));
    const row: Row = this.curve(lane, {
      name: `${name} intensity`, range: [0, 1], whole: [0, 1], points: () => now().points, blend: () => (now().blend === 'linear' ? 'linear' : 'spline'),
      edited: () => intensityEdit(this.shown, name) !== undefined, text: (value) => `${Math.round(value * 100)} %`,
      changed: (layer, points) => {
        dragged = undefined;
        return setIntensity(layer, name, points.map(([at, value, ...rest]): Point => [at, Math.round(value * 100) / 100, ...rest]), session.speech, now().blend);
      },
      show: (points) => {
        dragged = points;
        void session.showIntensity(now(), { points, blend: now().blend });
      },
      setBlend: (blend) => {
        const tangent = blend === 'smooth' ? 'flat' : blend === 'hold' ? 'step' : undefined; // an intensity as a whole is linear or auto
        const points = now().points.map(([at, value]): Point => (tangent === undefined ? [at, value] : [at, value, tangent]));
        session.commit(setIntensity(session.layer, name, points, session.speech, blend === 'linear' ? 'linear' : 'smooth'));
      },
    });
    lane.head.title = 'Double-click the lane to add a key';
    return row;
  }

  private channel(name: string): Row {
    const { session } = this;
    const facts = session.facts.get(name);
    const whole: [number, number] = [facts?.minimum ?? 0, facts?.maximum ?? 1];
    const unit = facts?.unit === 'degrees' ? '°' : '';
    const points = (): Point[] => {
      const edit = channelEdit(this.shown, name);
      return edit === undefined ? [] : pointsOf(edit.keys, session.speech);
    };
    const changed = (layer: Layer, keys: readonly Point[]): Layer => setChannel(layer, name, keys, session.speech, channelEdit(layer, name)?.mode ?? 'replace');
    const lane: Lane = new Lane(name, 'channel', this.window, (brush) => {
      if (this.other !== undefined) paintChannel(brush, this.other, name, row.curve?.range ?? whole, true);
      if (this.clip !== undefined) paintChannel(brush, this.clip, name, row.curve?.range ?? whole);
    }, name,
      this.plus(`Add a key to ${name} at the playhead`, () => {
        if (row.curve !== undefined) this.add(row.curve, this.playback.now, this.valueAt(row.curve, this.playback.now));
      }),
      button(`Reset ${name}`, () => session.commit(setChannel(session.layer, name, [], session.speech, 'replace')), { class: 'small reset' }, icon(ICONS.undo)),
      button(`Hide ${name}`, () => this.channels.toggle(name, false), { class: 'small' }, icon(ICONS.cross)));
    const row: Row = this.curve(lane, {
      name, range: [...whole], whole, points, changed, blend: () => channelEdit(this.shown, name)?.interpolation ?? 'smooth',
      edited: () => channelEdit(this.shown, name) !== undefined,
      text: (value) => `${unit === '' ? value.toFixed(2) : value.toFixed(1)}${unit}`,
      show: (keys) => session.show(changed(session.layer, keys)),
      setBlend: (blend) => session.commit({ ...session.layer, edits: session.layer.edits.map((edit) => (edit.kind === 'channel' && edit.channel === name ? { ...edit, interpolation: blend, keys: edit.keys.map(({ anchor, value }) => ({ anchor, value })) } : edit)) }),
    });
    lane.head.title = 'Double-click the lane to add a key';
    return row;
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
      this.scrubbed(this.playback.now);
      body.setPointerCapture(event.pointerId);
      const move = (to: PointerEvent): void => {
        this.playback.seek(this.secondsAt(to));
        this.scrubbed(this.playback.now);
      };
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
