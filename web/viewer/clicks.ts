/** If the pointer moves farther than this while it is pressed (CSS pixels), the press is a drag. */
export const mostDrift = 5;

/**
 * Calls `clicked` for each click and tap on an element, which is a press of the main button without a drag. A
 * drag that returns to its start is not a click, because it has rotated the view meanwhile.
 */
export function listenToClicks(
  element: HTMLElement,
  clicked: (event: PointerEvent) => void,
  signal?: AbortSignal,
): void {
  const options = signal ? { signal } : {};
  let down: { x: number; y: number; id: number; drift: number } | null = null;
  const moved = ({ clientX, clientY, pointerId }: PointerEvent) => {
    if (down?.id !== pointerId) return;
    down.drift = Math.max(down.drift, Math.hypot(clientX - down.x, clientY - down.y));
  };
  element.addEventListener(
    "pointerdown",
    ({ button, isPrimary, clientX: x, clientY: y, pointerId: id }) => {
      down = button === 0 && isPrimary ? { x, y, id, drift: 0 } : null;
    },
    options,
  );
  element.addEventListener("pointermove", moved, options);
  element.addEventListener(
    "pointerup",
    (event) => {
      moved(event);
      const pressed = down;
      down = null;
      if (pressed?.id === event.pointerId && pressed.drift <= mostDrift) clicked(event);
    },
    options,
  );
}
