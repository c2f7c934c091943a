import { html, nothing, type TemplateResult } from "lit";
import { pageTexts } from "../../texts/page.ts";
import { startTexts } from "../../texts/start.ts";
import { withoutOptions } from "../../texts/without_options.ts";
import { formatBytes, formatCount, formatDims, formatType, formatValue } from "../shell/format.ts";
import { icon } from "../shell/icons.ts";
import { thumbnail } from "../shell/thumbnails.ts";
import type { SceneEntry, VolumeEntry } from "../shell/volumes_api.ts";

/**
 * `served`: the URL of the server's picture, which is shown if this browser keeps none. `failed`: called if it
 * cannot be loaded.
 */
export function volumeCard(
  volume: VolumeEntry,
  served: string | null,
  failed: () => void,
): TemplateResult {
  const title = volume.title || volume.name;
  if (volume.error) return brokenCard(title, withoutOptions(volume.error.message));
  const voxels = volume.voxels?.reduce((product, n) => product * n, 1);
  const picture = (volume.contentId && thumbnail(volume.contentId)) || served;
  return html`<a class="card" data-name=${volume.name} href="?volume=${encodeURIComponent(volume.name)}">
    <div class="card-picture">
      ${picture ? html`<img src=${picture} alt="" loading="lazy" @error=${failed} />` : sparkline(volume)}
    </div>
    <h2>${title}</h2>
    <p class="card-facts">
      ${volume.voxels ? html`<span>${formatDims(volume.voxels)}</span>` : nothing}
      ${volume.type ? html`<span>${formatType(volume.type)}</span>` : nothing}
      ${volume.fileBytes ? html`<span>${formatBytes(volume.fileBytes)}</span>` : nothing}
    </p>
    <p class="card-facts quiet">
      ${voxels ? html`<span>${startTexts.voxels(formatCount(voxels))}</span>` : nothing}
      ${
        volume.range
          ? html`<span>${pageTexts.to(formatValue(volume.range[0]), formatValue(volume.range[1]))}${volume.units ? ` ${volume.units}` : ""}</span>`
          : nothing
      }
    </p>
  </a>`;
}

/** The histogram on a logarithmic scale. A card shows it until there is a picture of the volume. */
function sparkline(volume: VolumeEntry): TemplateResult | typeof nothing {
  const counts = volume.histogram?.counts;
  if (!counts || counts.length === 0) return nothing;
  const most = Math.log1p(Math.max(1, ...counts));
  const points = counts.map((count, i) => {
    const x = (100 * i) / Math.max(1, counts.length - 1);
    return `${x.toFixed(2)} ${(40 - (36 * Math.log1p(Math.max(0, count))) / most).toFixed(2)}`;
  });
  return html`<svg class="sparkline" viewBox="0 0 100 40" preserveAspectRatio="none" aria-hidden="true">
    <path d="M0 40 L${points.join(" L")} L100 40Z" />
  </svg>`;
}

export function skeleton(): TemplateResult {
  return html`<ul class="cards" aria-busy="true" aria-label=${startTexts.loading}>
    ${[0, 1, 2, 3, 4, 5].map(() => html`<li class="card ghost"><div class="card-picture"></div></li>`)}
  </ul>`;
}

/** As volumeCard. */
export function sceneCard(
  scene: SceneEntry,
  served: string | null,
  failed: () => void,
): TemplateResult {
  const title = scene.title || scene.name;
  if (scene.error) return brokenCard(title, withoutOptions(scene.error.message));
  const picture = (scene.contentId && thumbnail(scene.contentId)) || served;
  return html`<a class="card" data-scene=${scene.name} href="?scene=${encodeURIComponent(scene.name)}">
    <div class="card-picture">
      ${picture ? html`<img src=${picture} alt="" loading="lazy" @error=${failed} />` : icon("layers")}
    </div>
    <h2>${title}</h2>
    <p class="card-facts">
      ${scene.layers === undefined ? nothing : html`<span>${startTexts.layers(scene.layers)}</span>`}
      ${scene.steps === undefined ? nothing : html`<span>${startTexts.steps(scene.steps)}</span>`}
      ${scene.fileBytes ? html`<span>${formatBytes(scene.fileBytes)}</span>` : nothing}
    </p>
    ${title === scene.name ? nothing : html`<p class="card-facts quiet"><span>${scene.name}</span></p>`}
  </a>`;
}

function brokenCard(title: string, message: string): TemplateResult {
  return html`<div class="card broken">
    <div class="card-picture">${icon("alert")}</div>
    <h2>${title}</h2>
    <p class="card-facts">${message}</p>
  </div>`;
}
