// Draws with NiiVue's volume renderer, opaque from the isovalue on and lit by gradients. Its
// projection is parallel, and it turns about the volume's centre, so the scale is that at the
// target's distance.
import { Niivue, NVImage } from "@niivue/niivue";
import { nifti } from "../../../bench/harness/nifti.ts";

export async function draw(scene, values, container) {
  const canvas = document.createElement("canvas");
  container.append(canvas);
  canvas.style.cssText = "width: 100%; height: 100%";
  const niivue = new Niivue({
    backColor: [...scene.background, 1],
    show3Dcrosshair: false,
    isOrientCube: false,
    isOrientationTextVisible: false,
    isColorbar: false,
    crosshairWidth: 0,
  });
  await niivue.attachToCanvas(canvas);
  const [r, g, b] = scene.colour.map((c) => [Math.round(255 * c), Math.round(255 * c)]);
  niivue.addColormap("surface", { R: r, G: g, B: b, A: [0, 255], I: [0, 255] });
  const image = await NVImage.loadFromUrl({
    url: nifti(scene.voxels, scene.spacing, values).buffer,
    name: "volume.nii",
    colormap: "surface",
    cal_min: scene.isovalue,
    cal_max: scene.isovalue + 0.5,
  });
  niivue.addVolume(image);
  niivue.setSliceType(niivue.sliceTypeRender);
  await niivue.setVolumeRenderIllumination(1);
  niivue.setRenderAzimuthElevation(scene.niivue.azimuth, scene.niivue.elevation);
  niivue.setScale(scene.niivue.scale);
  niivue.drawScene();
}
