// German: what the page has in place of its English texts.
import { capture } from "./capture.de.ts";
import { device } from "./device.de.ts";
import { deviceError } from "./device_errors.de.ts";
import { fault } from "./faults.de.ts";
import { help } from "./help.de.ts";
import { layers } from "./layers.de.ts";
import { measure } from "./measure.de.ts";
import { overlay } from "./overlay.de.ts";
import { page } from "./page.de.ts";
import { panel } from "./panel.de.ts";
import { session } from "./session.de.ts";
import { slices } from "./slices.de.ts";
import { start } from "./start.de.ts";
import { surface } from "./surface.de.ts";
import { time } from "./time.de.ts";

export const translation = {
  capture,
  device,
  deviceError,
  fault,
  help,
  layers,
  measure,
  overlay,
  page,
  panel,
  session,
  slices,
  start,
  surface,
  time,
};
