/**
 * The style sheets of the overlays. Colours are inherited: the colour of text, --overlay-surface behind
 * text, --overlay-quiet for lines, --overlay-accent for handles. Positions are inherited too:
 * --overlay-axes-inset, --overlay-axes-size, --overlay-scale-bottom.
 */

const layer = `
  :host {
    position: absolute;
    inset: 0;
    overflow: hidden;
    pointer-events: none;
    font-size: 0.75rem;
    font-variant-numeric: tabular-nums;
    --behind-text: var(--overlay-surface, #fff);
  }
  .overlay-box, .clip-edges {
    position: absolute;
    inset: 0;
    width: 100%;
    height: 100%;
  }
`;

export const overlayStyles = `${layer}
  .overlay-box line {
    stroke: var(--overlay-quiet, #5c6672);
    stroke-width: 1;
  }
  .overlay-box .behind {
    stroke-dasharray: 3 4;
    opacity: 0.6;
  }
  .overlay-box text {
    fill: currentColor;
    stroke: var(--behind-text);
    stroke-width: 3;
    paint-order: stroke;
  }
  .overlay-axes {
    position: absolute;
    inset: var(--overlay-axes-inset, 0.75rem auto auto 0.75rem);
    width: var(--overlay-axes-size, 92px);
    height: var(--overlay-axes-size, 92px);
  }
  .overlay-axis {
    pointer-events: auto;
    cursor: pointer;
  }
  .overlay-axis line {
    stroke: var(--axis);
    stroke-width: 2.5;
  }
  .overlay-axis circle {
    fill: var(--axis);
    stroke: var(--axis);
    stroke-width: 1.5;
  }
  .overlay-axis .area, .overlay-axis:is(:hover, :focus-visible) .area {
    fill: transparent;
    stroke: none;
  }
  .overlay-axis circle.negative { fill: var(--behind-text); }
  .overlay-axis text {
    fill: #fff;
    font-size: 10px;
    font-weight: 600;
  }
  .overlay-axis .negative + text { fill: currentColor; }
  .overlay-axis:hover circle { stroke: currentColor; }
  .overlay-axis:focus { outline: none; }
  .overlay-axis:focus-visible circle {
    stroke: currentColor;
    stroke-width: 3;
  }
  .overlay-scale {
    position: absolute;
    inset: auto 0.75rem var(--overlay-scale-bottom, 0.75rem) auto;
    padding: 0.25rem 0.5rem;
    border-radius: 8px;
    background: color-mix(in oklab, var(--behind-text) 86%, transparent);
    text-align: center;
  }
  .overlay-scale-bar {
    margin: 0 auto 0.15rem;
    height: 0.4rem;
    border: 1.5px solid currentColor;
    border-block-start: none;
  }
`;

export const clipStyles = `${layer}
  .clip-edges line {
    stroke: var(--overlay-accent, #0f7c8c);
    stroke-width: 1.25;
    opacity: 0.75;
  }
  /* 24 px is the least that a pointer hits; the mark in it is smaller. */
  .clip-handle {
    position: absolute;
    inset: -14px auto auto -14px;
    width: 28px;
    height: 28px;
    border-radius: 50%;
    pointer-events: auto;
    touch-action: none;
    cursor: grab;
  }
  .clip-handle.dragged { cursor: grabbing; }
  .clip-handle::before {
    content: "";
    position: absolute;
    inset: 7px;
    border: 2px solid var(--overlay-accent, #0f7c8c);
    border-radius: 50%;
    background: var(--behind-text);
    box-sizing: border-box;
  }
  .clip-handle.behind::before {
    inset: 9px;
    opacity: 0.7;
  }
  .clip-handle:hover::before, .clip-handle.dragged::before { background: var(--overlay-accent, #0f7c8c); }
  .clip-handle:focus-visible { outline: var(--overlay-focus, 2px solid var(--overlay-accent, #0f7c8c)); }
  .clip-value {
    display: none;
    position: absolute;
    inset: 50% auto auto 100%;
    translate: 0 -50%;
    padding: 0.1rem 0.4rem;
    border-radius: 6px;
    background: color-mix(in oklab, var(--behind-text) 90%, transparent);
    white-space: nowrap;
    pointer-events: none;
  }
  .clip-handle.at-right .clip-value { inset: 50% 100% auto auto; }
  .clip-handle:is(:hover, .dragged, :focus-visible) .clip-value { display: block; }
  @media (pointer: coarse) {
    .clip-handle {
      inset: -22px auto auto -22px;
      width: 44px;
      height: 44px;
    }
    .clip-handle::before { inset: 13px; }
    .clip-handle.behind::before { inset: 15px; }
  }
`;
