/** Whether this is a phone or a tablet: its pointer is a finger, and cannot hover. */
export function isHandheld(): boolean {
  return (
    typeof matchMedia === "function" && matchMedia("(pointer: coarse) and (hover: none)").matches
  );
}

/**
 * The sample budget for the class of this device. A sample takes 16 bytes, so the budget is 32 MB
 * of GPU memory on small devices, and at most 384 MB.
 */
export function defaultSampleBudget(): number {
  if (typeof navigator === "undefined") return 8_000_000;
  // Chromium reports at most 8 GB. Other browsers report nothing.
  const { deviceMemory } = navigator as { deviceMemory?: number };
  if (deviceMemory !== undefined && deviceMemory <= 2) return 2_000_000;
  if (isHandheld()) return 4_000_000;
  return deviceMemory === undefined || deviceMemory >= 8 ? 24_000_000 : 12_000_000;
}
