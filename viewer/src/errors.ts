/** Something that came is not what it should be; the message is one line for the person who made it. */
export class MienError extends Error {
  override name = 'MienError';
}
