import { pageTexts } from "../../texts/page.ts";
import { defaultLight, type Light, lightRanges } from "../../viewer/light.ts";
import { lightNames, lightSettings } from "../../viewer/light_settings.ts";

/**
 * The parameters of the address that set the light, and the settings in each of them. Later settings
 * of a parameter may be left out. `isosplat render` has options of the same names.
 */
export const lightParameters: Readonly<Record<string, readonly (keyof Light)[]>> = groupedNames();

function groupedNames(): Record<string, (keyof Light)[]> {
  const groups: Record<string, (keyof Light)[]> = {};
  for (const name of lightNames) {
    const { parameter } = lightSettings[name];
    groups[parameter] = [...(groups[parameter] ?? []), name];
  }
  return groups;
}

/** The settings in a parameter's value; undefined if it is invalid. */
export function readLight(parameter: string, text: string): Partial<Light> | undefined {
  const names = lightParameters[parameter] ?? [];
  const values = text.split(",").map((part) => (part.trim() === "" ? Number.NaN : Number(part)));
  if (values.length > names.length || (parameter === "light" && values.length !== 2))
    return undefined;
  const light: Partial<Light> = {};
  for (const [i, value] of values.entries()) {
    const name = names[i] as keyof Light;
    const [low, high] = lightRanges[name];
    if (!(value >= low && value <= high)) return undefined;
    light[name] = value;
  }
  return light;
}

/** The values that readLight accepts, in words for the visitor. */
export function expectedOfLight(parameter: string): string {
  const ranges = (lightParameters[parameter] ?? []).map((name) => rangeText(lightRanges[name]));
  return pageTexts.isInRanges(ranges.join(", "));
}

function rangeText([low, high]: readonly [number, number]): string {
  return pageTexts.to(String(low), String(high));
}

/** The value of a parameter, without trailing defaults; undefined if all settings are defaults. */
export function writeLight(parameter: string, light: Light): string | undefined {
  const names = lightParameters[parameter] ?? [];
  const last = names.findLastIndex((name) => light[name] !== defaultLight[name]);
  if (last < 0) return undefined;
  const shown = parameter === "light" ? names : names.slice(0, last + 1);
  return shown.map((name) => String(light[name])).join(",");
}
