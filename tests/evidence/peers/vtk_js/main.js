// Acts like a user of vtk.js: fetches the whole volume, runs marching cubes, and draws triangles.
// ?volume=FILE.raw.gz&dims=x,y,z&spacing=x,y,z&isovalue=V[&next=W]
import "@kitware/vtk.js/Rendering/Profiles/Geometry";
import vtkDataArray from "@kitware/vtk.js/Common/Core/DataArray";
import vtkImageData from "@kitware/vtk.js/Common/DataModel/ImageData";
import vtkImageMarchingCubes from "@kitware/vtk.js/Filters/General/ImageMarchingCubes";
import vtkActor from "@kitware/vtk.js/Rendering/Core/Actor";
import vtkMapper from "@kitware/vtk.js/Rendering/Core/Mapper";
import vtkGenericRenderWindow from "@kitware/vtk.js/Rendering/Misc/GenericRenderWindow";

const asked = new URL(location.href).searchParams;
const numbers = (name) => asked.get(name).split(",").map(Number);

const answer = await fetch(asked.get("volume"));
const text = answer.body.pipeThrough(new DecompressionStream("gzip"));
const values = new Uint8Array(await new Response(text).arrayBuffer());

const image = vtkImageData.newInstance({ spacing: numbers("spacing") });
image.setDimensions(numbers("dims"));
image.getPointData().setScalars(vtkDataArray.newInstance({ name: "values", values }));

const contour = vtkImageMarchingCubes.newInstance({ computeNormals: true, mergePoints: true });
contour.setInputData(image);
contour.setContourValue(Number(asked.get("isovalue")));
const mapper = vtkMapper.newInstance({ scalarVisibility: false });
mapper.setInputConnection(contour.getOutputPort());
const actor = vtkActor.newInstance();
actor.setMapper(mapper);

const view = vtkGenericRenderWindow.newInstance();
view.setContainer(document.getElementById("view"));
view.resize();
view.getRenderer().addActor(actor);
view.getRenderer().resetCamera();
view.getRenderWindow().render();
performance.mark("vtk:image");

globalThis.changeIsovalue = (isovalue) => {
  performance.mark("vtk:change");
  contour.setContourValue(isovalue);
  view.getRenderWindow().render();
  performance.mark("vtk:changed");
};
const next = asked.get("next");
if (next) setTimeout(() => globalThis.changeIsovalue(Number(next)), 1500);
