/** Named events with one payload each. */
export class Events<Map extends object> {
  private readonly heard = new Map<keyof Map, Set<(payload: never) => void>>();

  on<Name extends keyof Map>(name: Name, listener: (payload: Map[Name]) => void): void {
    const known = this.heard.get(name) ?? new Set();
    known.add(listener as (payload: never) => void);
    this.heard.set(name, known);
  }

  emit<Name extends keyof Map>(name: Name, payload: Map[Name]): void {
    for (const listener of this.heard.get(name) ?? []) (listener as (payload: Map[Name]) => void)(payload);
  }
}
