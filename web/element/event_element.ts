import type { IsosplatViewerEvents } from "./element_events.ts";

/**
 * Servers that render pages have no elements. The modules can be imported there, and do nothing.
 */
const BaseElement: typeof HTMLElement = globalThis.HTMLElement ?? class {};

/** An element whose listeners receive the types of `IsosplatViewerEvents`. */
export class EventElement extends BaseElement {
  override addEventListener<K extends keyof IsosplatViewerEvents>(
    type: K,
    listener: (this: this, event: IsosplatViewerEvents[K]) => unknown,
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
}
