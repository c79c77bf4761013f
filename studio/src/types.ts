// What the server and the page tell each other (docs/studio.md).
export type Span = [number, number, string];

export interface ChannelFacts { name: string; unit: string; minimum: number; maximum: number; group: string }
export interface Voice { name: string; language: string }
export interface Format { suffix: string; title: string; loses: string }

export interface About {
  version: string;
  performers: string[];
  voices: Voice[];
  emotions: string[];
  speech_models: string[];
  languages: string[];
  exports: string[];
  formats?: Format[];
  channels: ChannelFacts[];
  lights: string[];
  cameras: string[];
  limits: { upload_bytes: number; text_characters: number; seconds: number };
  default_face: string;
  /** How far jaw and lips go at which effort. */
  effort: { efforts: number[]; jaw: number[]; lips: number[] };
  /** Degrees to the speaker's left and up; and how many degrees the full weight of an eye's channel turns it. */
  gazes: Record<string, [number, number]>;
  gaze_degrees: { in: number; out: number; up: number; down: number };
}

/** A phone of a word, or the k-th pause after a word (null: before the first). `occurrence` counts from 1, the others from 0. */
export interface Place { word: string | null; occurrence?: number; phone?: number; pause?: number }
/** What the phones of a line belong to: first what is before the first word, then each word with the pauses after it. */
export interface LineWord { word: string | null; phones: string[]; pauses: string[] }
/** A moment tied to what is said: a share of a phone or of a pause. */
export interface Anchor extends Place { share: number }
export type Blend = 'linear' | 'smooth' | 'spline' | 'hold';

export interface BorderEdit { kind: 'border'; phone: Place; edge: 'start' | 'end'; shift: number }
/** How a curve passes a key. */
export type Tangent = 'auto' | 'flat' | 'linear' | 'step';
export interface Key { anchor: Anchor; value: number; tangent?: Tangent }
export interface IntensityEdit { kind: 'intensity'; emotion: string; interpolation: Blend; points: Key[] }
export interface ChannelEdit {
  kind: 'channel'; channel: string; mode: 'add' | 'replace'; interpolation: Blend; fade: number; keys: Key[];
}
export type Edit = BorderEdit | IntensityEdit | ChannelEdit;
export interface Layer { format: 'mien-edits'; version: 1; edits: Edit[]; [other: string]: unknown }
export interface Lost { edit: number; point?: number | null; why: string }

export interface Emotion { name: string; points: [number, number][]; interpolation?: Blend; start?: number | null; end?: number | null }
export interface TakeRequest {
  text?: string; emotion?: string | string[]; voice?: string | null; language?: string | null; fps?: string | number; seed?: number;
  performer?: string; speech_model?: string | null; prosody?: number; effort?: string; voice_emotion?: number; song?: boolean;
  times?: Times | null;
}
/** Words and phones as a person corrected them. */
export interface Times { words: Span[]; phones: Span[] }
/** One state of a take, as undo and redo know it. */
export interface Step { request: TakeRequest; layer: Layer; sound: string | null }
export interface History { name: string; made: number; steps: Step[]; at: number }
export interface Listed { take: string; name: string; made: number; text: string; emotion: string[]; from_sound: boolean; edits: number; steps: number }
export interface Take {
  take: string;
  request: TakeRequest;
  from_sound?: boolean;
  fps: number;
  frames: number;
  seconds: number;
  text: string;
  words: Span[];
  phones: Span[];
  emotions: Emotion[];
  channels: string[];
  notes: { kind: string; message: string }[];
  edits?: Layer;
  line?: LineWord[];
  lost?: Lost[];
  revision: number;
  name?: string;
  at?: number;
  count?: number;
}
export interface Job {
  state: 'queued' | 'running' | 'done' | 'failed' | 'cancelled';
  step?: string;
  done?: number;
  error?: string | null;
  field?: string | null;
  take?: string | null;
  /** A take with the beginning of the result, to be heard and seen meanwhile. */
  beginning?: string | null;
  file?: string | null;
  /** A head without shapes, and the face that it has become. */
  head?: string;
  face?: string;
}
export const emptyLayer = (): Layer => ({ format: 'mien-edits', version: 1, edits: [] });
