/** The style sheet of the element's shadow tree. A page's rules for the element take precedence. */
export const styles = `
  :host {
    display: block;
    position: relative;
    inline-size: 100%;
    aspect-ratio: 4 / 3;
    overflow: hidden;
    font: 0.875rem/1.4 system-ui, sans-serif;
    color: var(--isosplat-text, #20252c);
  }
  :host([hidden]) { display: none; }
  .picture, .picture > *, .poster {
    position: absolute;
    inset: 0;
    inline-size: 100%;
    block-size: 100%;
  }
  canvas { display: block; }
  .overlays {
    position: absolute;
    inset: 0;
    pointer-events: none;
    --overlay-surface: var(--isosplat-panel, #fffffff0);
    --overlay-accent: var(--isosplat-accent, #0f7c8c);
  }
  :host([controls]) .overlays { --overlay-scale-bottom: 3.5rem; }
  :host([controls]) .overlays:has(~ .controls .time:not([hidden])) { --overlay-scale-bottom: 6rem; }
  ::slotted(isosplat-layer) { display: none; }
  canvas:focus-visible, .picture:focus-visible { outline: 2px solid var(--isosplat-accent, #0f7c8c); outline-offset: -2px; }
  .poster[hidden], .message[hidden], .controls[hidden], .time[hidden] { display: none; }
  .poster { pointer-events: none; }
  .message {
    position: absolute;
    inset-inline: 0.75rem;
    inset-block-start: 0.75rem;
    padding: 0.5rem 0.75rem;
    border-radius: 6px;
    background: var(--isosplat-panel, #fffffff0);
    overflow-wrap: anywhere;
  }
  .controls {
    position: absolute;
    inset-inline: 0.5rem;
    inset-block-end: 0.5rem;
    display: grid;
    grid-template-columns: minmax(0, 1fr);
    gap: 0.25rem;
    padding: 0.25rem 0.5rem;
    border-radius: 6px;
    background: var(--isosplat-panel, #fffffff0);
  }
  .row, .time {
    display: flex;
    gap: 0.5rem;
    align-items: center;
  }
  .row { flex-wrap: wrap; }
  .time svg { display: block; inline-size: 1em; fill: currentColor; }
  .time span { min-inline-size: 4em; text-align: end; font-variant-numeric: tabular-nums; }
  .controls input[type="range"] {
    flex: 1;
    min-inline-size: 3rem;
    accent-color: var(--isosplat-accent, #0f7c8c);
  }
  .controls { container-type: inline-size; }
  @container (max-width: 24rem) { .time select { display: none; } }
  .time select { max-inline-size: 6em; }
  .controls input:not([type="range"]) { inline-size: 5.5em; }
  .controls input, .controls select, .controls button { font: inherit; color: inherit; }
  .controls input:not([type="range"]), .controls select, .controls button {
    padding: 0.15rem 0.4rem;
    border: 1px solid color-mix(in srgb, currentColor 35%, transparent);
    border-radius: 4px;
    background: transparent;
    min-block-size: 1.75rem;
  }
`;
