/**
 * <isosplat-viewer> as a widget of notebooks: a module that follows anywidget's front-end
 * specification (AFM).
 */
import "./index.ts";
import { type FileOf, Notebook, type NotebookModel } from "./notebook.ts";

export { type KernelMessages, kernelFile } from "./kernel_file.ts";
export type { FileOf, NotebookModel } from "./notebook.ts";
export type {
  LayerTrait,
  PickedPoint,
  TimeTrait,
  TraitName,
  Traits,
  VolumeTrait,
} from "./notebook_traits.ts";

/**
 * Shows the model in `el`. Returns a function that removes everything again. `fileOf`: reads the files behind
 * addresses that the browser cannot reach.
 */
function render({
  model,
  el,
  fileOf,
}: {
  model: NotebookModel;
  el: HTMLElement;
  fileOf?: FileOf;
}): () => void {
  const notebook = new Notebook(model, fileOf);
  el.append(notebook.element);
  return () => notebook.dispose();
}

export default { render };
