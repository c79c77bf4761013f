// The studio's page, put together.
import * as api from './api';
import { button, make, options, showFault } from './dom';
import { VIEWS, LIGHTINGS } from './looks';
import { Compared } from './compared';
import { PageKeeper, type PageState } from './page_state';
import { EditsPanel } from './panels/edits';
import { ExportPanel } from './panels/export';
import { FacePanel } from './panels/face';
import { LinePanel } from './panels/line';
import { LiveButton } from './panels/live';
import { RigPanel } from './panels/rig';
import { TakesPanel } from './panels/takes';
import { Playback } from './playback';
import { Scrubber } from './scrub';
import { Session } from './session';
import { helpDialog, listenToKeys } from './shortcuts';
import { split } from './splitter';
import { Stage } from './stage';
import { Timeline } from './timeline/timeline';
import { Trial } from './trial';
import { Tabs } from './tabs';
import { transport } from './transport';
import './style.css';

/** For benchmarks and tests: how long pictures take, and what is shown. */
interface Stats {
  /** Milliseconds from picture to picture while the face plays, and of work for each on the page's thread. */
  summary: Stage['times']['summary'];
  reset: () => void;
  intervals: readonly number[];
  work: readonly number[];
  /** The take and the frames that are shown. */
  shown: () => { take: string; revision: number; seconds: number; channels: readonly string[]; values: Float32Array } | null;
  /** What the first mesh with such a morph target stands at. */
  influence: (target: string) => number | undefined;
  /** The face under the tree in the deformation editor: parts' vertices one after the other, mm, and the parameter's values. */
  tree: () => { rig: string; values: Record<string, number>; vertices: Float32Array[] } | null;
}

declare global {
  interface Window { mienStats: Stats }
}

async function start(): Promise<void> {
  const session = new Session(await api.about());
  const playback = new Playback();
  const canvas = make('canvas', { 'aria-label': 'The face', role: 'img' });
  const backdrop = make('div', { class: 'backdrop' }, canvas);
  const stage = new Stage(canvas, backdrop);
  const timeline = new Timeline(session, playback);
  let growing = false; // the beginning of a longer line is shown
  const help = helpDialog();

  const lights = make('select', { 'aria-label': 'Light', id: 'light' });
  options(lights, Object.keys(LIGHTINGS).map((name): [string, string] => [name, `light: ${name}`]), 'portrait');
  lights.addEventListener('change', () => stage.light(lights.value));
  const views = make('select', { 'aria-label': 'Camera', id: 'camera' });
  options(views, Object.keys(VIEWS).map((name): [string, string] => [name, `camera: ${name}`]), 'portrait');
  const view = (name: string): void => { views.value = name; stage.view(name); };
  views.addEventListener('change', () => view(views.value));

  let rig: RigPanel | undefined;
  const compared = new Compared(session, playback);
  const show = (): void => {
    if (rig?.active === true) stage.touch();
    else if (session.clip !== undefined) {
      const clip = compared.instead ?? session.clip;
      stage.beside = compared.pose();
      stage.pose(clip.channels, clip.sample(playback.now));
    } else stage.mask(undefined, 0);
  };
  const back = (): void => { if (session.take !== undefined && !session.working) session.show(session.layer); else show(); };
  const page = new PageKeeper(() => state());
  const line = new LinePanel(session, stage, new Trial(session, playback), back, () => page.touch(), () => {
    if (playback.playing) return;
    playback.seek(playback.loop?.[0] ?? 0);
    void playback.play();
  });
  const face = new FacePanel(session, stage, () => { show(); void line.emotions.draw(face.id); page.touch(); });
  rig = new RigPanel(session, stage, () => ({ id: face.id, name: face.name }), show);
  const files = new ExportPanel(session, () => ({ face: face.id, light: lights.value, camera: views.value }));
  const takes = new TakesPanel(session, (take) => void compared.choose(take), (opened) => look(opened as PageState));
  const tabs = new Tabs([
    ['line', 'Line', line.element], ['takes', 'Takes', takes.element], ['edits', 'Edits', new EditsPanel(session).element],
    ['face', 'Face', face.element], ['export', 'Export', files.element],
    ['rig', 'Rig', rig.element],
  ], timeline.element, (name) => {
    if (name === 'rig') void rig?.show();
    else if (name !== 'timeline') rig?.hide();
    if (name !== 'face' && name !== 'timeline') face.head.leave();
    page.touch();
  });
  const state = (): PageState => ({
    ...(session.take === undefined || session.take.take === 'beginning' ? {} : { take: session.take.take }), line: line.draft, face: face.id,
    light: lights.value, camera: views.value, tab: document.body.dataset['tab'] ?? 'line', ...timeline.state(), ...(splitter.height() === undefined ? {} : { height: splitter.height() }),
  });
  /** As the page looked before. */
  const look = (before: PageState): void => {
    if (before.light !== undefined && before.light in LIGHTINGS) { lights.value = before.light; stage.light(before.light); }
    if (before.camera !== undefined && before.camera in VIEWS) view(before.camera);
    if (before.line !== undefined && session.take === undefined) line.draft = before.line;
    if (before.tab !== undefined && before.tab !== 'rig') tabs.choose(before.tab);
    if (before.height !== undefined) splitter.set(before.height);
    timeline.restore(before);
  };

  const live = new LiveButton(session, playback);
  const told = make('div', { class: 'told', role: 'status', 'aria-live': 'polite' });
  const toast = make('p', { class: 'toast', role: 'alert', hidden: true });
  const stageArea = make('section', { id: 'stage', 'aria-label': 'Face' }, backdrop, make('div', { class: 'looks' }, views, lights), told, toast);
  const main = make('main', {}, make('h1', { class: 'visually-hidden' }, 'mien studio'), stageArea, tabs.element, transport(playback, session, live.element, () => help.showModal()), timeline.element, help, live.dialog);
  const splitter = split(main, timeline.element, () => page.touch());
  timeline.element.prepend(splitter.element);
  stageArea.querySelector('.looks')?.append(compared.element);
  document.body.append(main);
  compared.on('change', () => { timeline.setOther(compared.clip); show(); });

  const scrubber = new Scrubber();
  timeline.scrubbed = (at) => scrubber.play(at);
  session.on('frames', show);
  playback.on('time', show);
  session.on('layer', () => page.touch());
  for (const name of ['time', 'state'] as const) playback.on(name, () => { if (!playback.playing) page.touch(); });
  timeline.window.on('change', () => page.touch());
  timeline.changed = () => page.touch();
  session.on('take', ({ take, fresh, other }) => {
    if (!fresh || session.sound === undefined) return;
    const [at, loop, going] = [playback.now, playback.loop, playback.playing];
    const waited = !going && at >= playback.seconds - 0.05 && playback.seconds > 0;
    playback.load(session.sound, take.seconds, take.fps);
    if (!other) { // the same line again: one stays where one was
      playback.seek(Math.min(at, take.seconds));
      playback.setLoop(loop !== null && loop[1] <= take.seconds ? loop : null);
      if (going || (waited && growing)) void playback.play();
    }
    growing = take.take === 'beginning';
    if (growing && other) void playback.play().catch(() => undefined); // a browser may want a click first
    void decoded(session.sound).then((sound) => { scrubber.set(sound); timeline.setSound(sound.getChannelData(0), sound.sampleRate); });
    if (take.take === 'beginning') return;
    if (new URLSearchParams(location.hash.slice(1)).get('take') !== take.take) history.pushState(null, '', `#take=${take.take}`);
    document.title = `${take.name ?? take.text} · mien studio`;
    page.touch();
  });
  const byAddress = (): Promise<boolean> | undefined => {
    const id = new URLSearchParams(location.hash.slice(1)).get('take');
    return id === null || id === session.take?.take ? undefined : session.open(id);
  };
  addEventListener('hashchange', () => void byAddress());
  document.addEventListener('visibilitychange', () => { if (!document.hidden) { void session.refresh(); session.emit('list', undefined); } });
  addEventListener('focus', () => void session.refresh());
  addEventListener('beforeunload', (event) => { if (!session.safe || files.unsaved) event.preventDefault(); });
  session.on('kept', (safe) => { document.body.dataset['kept'] = String(safe); });
  session.on('busy', (job) => {
    told.replaceChildren(...(job === null ? [] : [
      make('span', {}, `${job.step || job.state} …`), make('progress', { max: 1, ...(job.done ? { value: job.done } : {}) }),
      button('Cancel', () => session.stopWork(), { class: 'small' })]));
  });
  let hiding = 0;
  session.on('problem', ({ message, field }) => {
    if (field !== null && showFault(field, message)) tabs.reveal(field);
    else toast.textContent = message;
    toast.hidden = field !== null && document.getElementById(`fault-${field}`) !== null;
    clearTimeout(hiding);
    hiding = window.setTimeout(() => { toast.hidden = true; }, 12_000);
  });
  listenToKeys({ playback, session, timeline, help: () => help.showModal(), view: (place) => view(Object.keys(VIEWS)[place] ?? 'portrait') });
  dropFiles(line, face, takes, tabs, session);

  const { times } = stage;
  window.mienStats = { summary: () => times.summary(), reset: () => times.reset(), intervals: times.intervals, work: times.work,
    shown: () => (session.clip === undefined ? null : { take: session.take?.take ?? '', revision: session.take?.revision ?? 0, seconds: playback.now, channels: session.clip.channels, values: session.clip.values }),
    influence: (target) => stage.influence(target),
    tree: () => (rig?.editor === undefined ? null : { rig: rig.id, values: Object.fromEntries(rig.editor.values), vertices: rig.editor.vertices() }) };
  const tick = (): void => {
    playback.tick();
    stage.draw(playback.playing);
    requestAnimationFrame(tick);
  };
  tick();
  const before = (await api.page().catch(() => ({}))) as PageState;
  await session.bringUnsent().catch(() => undefined);
  const chosen = before.face !== undefined && before.face !== '' ? before.face : session.about.default_face;
  await face.list().catch((problem: unknown) => session.tell(problem));
  await face.show(chosen).catch(() => face.show(session.about.default_face)).catch((problem: unknown) => session.tell(problem));
  look(before);
  if (!location.hash.includes('take=') && before.take !== undefined) history.replaceState(null, '', `#take=${before.take}`);
  await (byAddress() ?? Promise.resolve());
  if (before.view !== undefined && before.take === session.take?.take) timeline.restore(before);
  page.ready = true;
  void api.expressions('default').then((found) => { session.expressions = found; void line.emotions.draw(face.id); }).catch((problem: unknown) => session.tell(problem));
  document.body.dataset['ready'] = 'true';
}

async function decoded(wav: ArrayBuffer): Promise<AudioBuffer> {
  return new OfflineAudioContext(1, 1, 48_000).decodeAudioData(wav.slice(0));
}

/** Texts, sounds, faces, edits and projects may be dropped anywhere. */
function dropFiles(line: LinePanel, face: FacePanel, takes: TakesPanel, tabs: Tabs, session: Session): void {
  document.addEventListener('dragover', (event) => {
    event.preventDefault();
    document.body.classList.add('dropping');
  });
  document.addEventListener('dragleave', (event) => { if (event.relatedTarget === null) document.body.classList.remove('dropping'); });
  document.addEventListener('drop', (event) => {
    event.preventDefault();
    document.body.classList.remove('dropping');
    const file = event.dataTransfer?.files[0];
    if (file === undefined) return;
    if (/\.(glb|vrm)$/i.test(file.name)) {
      tabs.choose('face');
      void face.upload(file);
    } else if (/\.mienproject$/i.test(file.name)) {
      tabs.choose('takes');
      void takes.openProject(file);
    } else if (/\.textgrid$/i.test(file.name)) {
      tabs.choose('line');
      void line.useGrid(file);
    } else if (/\.(txt|xml|ssml|bml)$/i.test(file.name)) {
      tabs.choose('line');
      void file.text().then((text) => { line.text.value = text.trim(); });
    } else if (/\.json$/i.test(file.name)) {
      tabs.choose('edits');
      void file.text().then((text) => session.loadLayer(JSON.parse(text))).catch(() => session.emit('problem', { message: `${file.name} holds no edits of mien`, field: 'layer' }));
    } else {
      tabs.choose('line');
      line.useSound(file);
    }
  });
}

start().catch((problem: unknown) => {
  document.body.append(make('p', { class: 'broken', role: 'alert' }, problem instanceof Error ? problem.message : String(problem)));
});
