import { shownRange } from "../viewer/field_of.ts";
import { defaultLook, type Look } from "../viewer/types.ts";
import { maxNumber } from "./member.ts";
import {
  type JsonObject,
  lightMembers,
  maxFieldNameBytes,
  maxFieldSteps,
  objectOf,
} from "./scene_document.ts";

const utf8 = new TextEncoder();

/** The member `look`. Undefined if the look is the default and the scene had none. */
export function lookDocument(look: Look, before: unknown): JsonObject | undefined {
  const { background: _, field: __, light, colourBy, colourMap, eyeDome, ...splats } = look;
  const { background: ___, field: ____, ...defaults } = defaultLook;
  const isDefault = Object.entries(defaults).every(
    ([name, value]) => JSON.stringify(look[name as keyof Look]) === JSON.stringify(value),
  );
  if (isDefault && before === undefined) return undefined;
  const { light: lightBefore, field: fieldBefore, ...others } = objectOf(before);
  const field = fieldDocument(look, fieldBefore);
  const numbers = Object.fromEntries(lightMembers.map(([name, member]) => [member, light[name]]));
  return {
    ...others,
    ...splats,
    // Scenes cannot show a field without its name.
    colour_by: colourBy === "field" && !field ? defaultLook.colourBy : colourBy,
    colour_map: colourMap,
    field,
    light: { ...objectOf(lightBefore), ...numbers },
    eye_dome: eyeDome,
  };
}

/**
 * The field of the look, also while colours do not show it. Undefined if none was chosen, or if scenes cannot name it.
 * Unknown members belong to the field of the scene.
 */
function fieldDocument({ field }: Look, before: unknown): JsonObject | undefined {
  const { name, range, scale, steps, lines } = field;
  if (name === "" || utf8.encode(name).length > maxFieldNameBytes) return undefined;
  const known = objectOf(before);
  // Scenes have no logarithms of 0, which the renderer replaces.
  const ends = range && scale === "logarithmic" ? shownRange(range, scale) : range;
  const isRange = ends !== null && ends[0] < ends[1];
  const isCount = Number.isInteger(steps) && steps >= 2 && steps <= maxFieldSteps;
  return {
    ...(known.name === name && known),
    name,
    range: isRange ? ends : undefined,
    scale,
    steps: isCount ? steps : 0,
    lines: lines > 0 && lines <= maxNumber ? lines : undefined,
  };
}
