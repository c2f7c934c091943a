/** The example page, web/embed.html: two linked views of a volume of this server or site. */
import type { IsosplatViewerElement } from "./isosplat_viewer.ts";

const select = document.querySelector<HTMLSelectElement>("#volume");
const state = document.querySelector<HTMLElement>("#state");
const views = document.querySelector<HTMLElement>(".views");
const source = document.querySelector<HTMLElement>("#source");

/** The addresses of the volumes: of a server's list, or of the catalog of a static site. */
async function volumes(): Promise<{ name: string; src: string }[]> {
  const server = await fetch("v1/volumes");
  if (server.ok) {
    const { volumes: list } = (await server.json()) as { volumes: { name: string }[] };
    return list.map(({ name }) => ({ name, src: `v1/volumes/${encodeURIComponent(name)}` }));
  }
  const site = await fetch("catalog.json");
  if (!site.ok) return [];
  const { volumes: list } = (await site.json()) as { volumes: { name: string; url: string }[] };
  return list.map(({ name, url }) => ({ name, src: url }));
}

function markup(src: string): string {
  return [
    `<isosplat-viewer src="${src}" link="example" controls></isosplat-viewer>`,
    `<isosplat-viewer src="${src}" link="example" colour="c8553d"></isosplat-viewer>`,
  ].join("\n");
}

function show(src: string): void {
  if (!views || !source) return;
  const elements = [undefined, "c8553d"].map((colour) => {
    const element = document.createElement("isosplat-viewer");
    element.src = src;
    element.link = "example";
    if (colour) element.setAttribute("colour", colour);
    else element.controls = true;
    return element;
  });
  views.replaceChildren(...elements);
  const [first] = elements;
  first?.addEventListener("progress", (event) => {
    if (state) state.textContent = describe(event.currentTarget as IsosplatViewerElement);
  });
  const script = new URL("isosplat-viewer.js", document.baseURI).href;
  const absolute = new URL(src, document.baseURI).href;
  source.textContent = `<script type="module" src="${script}"></script>\n\n${markup(absolute)}`;
}

function describe({ progress, info }: IsosplatViewerElement): string {
  if (!progress || !info) return "";
  return `${info.voxels.join(" × ")} voxels, ${progress.state}`;
}

const list = await volumes();
select?.append(...list.map(({ name, src }) => new Option(name, src)));
select?.addEventListener("change", () => show(select.value));
if (list[0]) show(list[0].src);
else if (state) state.textContent = "There are no volumes here.";
