import { MienError } from './errors.js';
import { MotionClip, type Facts, type Span } from './motion.js';

const FORMAT = 'mien-animation';
const VERSION = 1;

type Loose = Record<string, unknown>;

/** Reads a native animation (`mien say ... -o line.json`). Its sound is left where it is: give a player a `.wav`. */
export function readAnimation(content: unknown, name = 'the animation'): MotionClip {
  const document = content as Loose | null;
  if (typeof document !== 'object' || document === null || document['format'] !== FORMAT) {
    throw new MienError(`${name} is not a ${FORMAT} file`);
  }
  if (document['version'] !== VERSION) {
    throw new MienError(`${name} is ${FORMAT} version ${String(document['version'])}; this player reads version ${VERSION}`);
  }
  const track = document['channels'] as Loose;
  const names = track['names'] as string[];
  const rows = track['values'] as number[][];
  if (!Array.isArray(names) || !Array.isArray(rows) || rows.some((row) => row.length !== names.length)) {
    throw new MienError(`${name}: its frames do not have one number for each of its channels`);
  }
  return new MotionClip(names, frameRate(track['rate'], name), Float32Array.from(rows.flat()), factsOf(document));
}

function frameRate(rate: unknown, name: string): number {
  const [over, under = 1] = String(rate).split('/').map(Number);
  const fps = (over as number) / under;
  if (!(fps > 0)) throw new MienError(`${name}: expected a frame rate such as '25' or '30000/1001', got ${String(rate)}`);
  return fps;
}

function factsOf(document: Loose): Facts {
  const speech = (document['utterance'] ?? {}) as Loose;
  const tier = (key: string): Span[] => ((speech[key] as Loose | undefined)?.['intervals'] ?? []) as Span[];
  const audio = (speech['audio'] ?? {}) as { samples?: number; rate?: number };
  const facts: Facts = { text: String(speech['text'] ?? ''), words: tier('words'), phones: tier('phones') };
  if (audio.samples !== undefined && audio.rate) facts.seconds = audio.samples / audio.rate;
  return facts;
}
