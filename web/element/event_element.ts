/**
 * Servers that render pages have no elements. The modules can be imported there, and do nothing.
 */
const BaseElement: typeof HTMLElement = globalThis.HTMLElement ?? class {};

/** An element whose listeners receive the types of `Events`: the events of the element by name. */
export class EventElement<Events extends Record<keyof Events, Event>> extends BaseElement {
  override addEventListener<K extends keyof Events & string>(
    type: K,
    listener: (this: this, event: Events[K]) => unknown,
    options?: boolean | AddEventListenerOptions,
  ): void;
  override addEventListener<K extends keyof HTMLElementEventMap>(
    type: K,
    listener: (this: HTMLElement, event: HTMLElementEventMap[K]) => unknown,
    options?: boolean | AddEventListenerOptions,
  ): void;
  override addEventListener(
    type: string,
    listener: EventListenerOrEventListenerObject,
    options?: boolean | AddEventListenerOptions,
  ): void;
  override addEventListener(
    type: string,
    // biome-ignore lint/suspicious/noExplicitAny: the overloads state the types
    listener: any,
    options?: boolean | AddEventListenerOptions,
  ): void {
    super.addEventListener(type, listener, options);
  }

  /** Null or undefined: removes the attribute. */
  protected setText(name: string, value: string | null | undefined): void {
    if (typeof value === "string") this.setAttribute(name, value);
    else this.removeAttribute(name);
  }

  /** A property that was set before the element was defined is an own property. Sets it again. */
  protected takeProperties(names: readonly string[]): void {
    const element = this as unknown as Record<string, unknown>;
    for (const name of names) {
      if (!Object.hasOwn(this, name)) continue;
      const value = element[name];
      delete element[name];
      element[name] = value;
    }
  }
}
