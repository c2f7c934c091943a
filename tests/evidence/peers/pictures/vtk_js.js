// Draws with vtk.js: marching cubes with normals from gradients, and the default light of a view.
import "@kitware/vtk.js/Rendering/Profiles/Geometry";
import vtkDataArray from "@kitware/vtk.js/Common/Core/DataArray";
import vtkImageData from "@kitware/vtk.js/Common/DataModel/ImageData";
import vtkImageMarchingCubes from "@kitware/vtk.js/Filters/General/ImageMarchingCubes";
import vtkActor from "@kitware/vtk.js/Rendering/Core/Actor";
import vtkMapper from "@kitware/vtk.js/Rendering/Core/Mapper";
import vtkGenericRenderWindow from "@kitware/vtk.js/Rendering/Misc/GenericRenderWindow";

export async function draw(scene, values, container) {
  const image = vtkImageData.newInstance({ spacing: scene.spacing });
  image.setDimensions(scene.voxels);
  image.getPointData().setScalars(vtkDataArray.newInstance({ name: "values", values }));
  const contour = vtkImageMarchingCubes.newInstance({ computeNormals: true, mergePoints: true });
  contour.setInputData(image);
  contour.setContourValue(scene.isovalue);
  const mapper = vtkMapper.newInstance({ scalarVisibility: false });
  mapper.setInputConnection(contour.getOutputPort());
  const actor = vtkActor.newInstance();
  actor.setMapper(mapper);
  actor.getProperty().setColor(...scene.colour);
  const view = vtkGenericRenderWindow.newInstance({ background: scene.background });
  view.setContainer(container);
  view.resize();
  const renderer = view.getRenderer();
  renderer.addActor(actor);
  const camera = renderer.getActiveCamera();
  camera.setPosition(...scene.eye);
  camera.setFocalPoint(...scene.target);
  camera.setViewUp(...scene.up);
  camera.setViewAngle(scene.fieldOfView);
  renderer.resetCameraClippingRange();
  view.getRenderWindow().render();
}
