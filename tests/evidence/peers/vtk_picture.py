#!/usr/bin/python3
"""Draws an isosurface with VTK: Flying Edges, normals from gradients, its own light.

    xvfb-run vtk_picture.py FILE X Y Z u8|i16|u16|f32 SX SY SZ ISOVALUE WIDTH HEIGHT COLOUR BACKGROUND
        FIELD_OF_VIEW EYE_X EYE_Y EYE_Z TARGET_X TARGET_Y TARGET_Z UP_X UP_Y UP_Z PLAIN.png SSAO.png

PLAIN: 8 samples per pixel. SSAO: with screen-space ambient occlusion, 256 samples in a tenth of the
volume's diagonal, and 4 × 4 pictures per pixel.
"""

import sys

from raw_volume import flying_edges, raw_volume
import vtkmodules.vtkRenderingOpenGL2  # noqa: F401 (registers the implementation)
from vtkmodules.vtkIOImage import vtkPNGWriter
from vtkmodules.vtkRenderingCore import (
    vtkActor,
    vtkPolyDataMapper,
    vtkRenderer,
    vtkRenderWindow,
    vtkWindowToImageFilter,
)
from vtkmodules.vtkRenderingOpenGL2 import vtkRenderStepsPass, vtkSSAAPass, vtkSSAOPass


def rgb(text):
    return [int(text[i : i + 2], 16) / 255 for i in (0, 2, 4)]


def save(window, path):
    window.Render()
    image = vtkWindowToImageFilter()
    image.SetInput(window)
    image.ReadFrontBufferOff()
    writer = vtkPNGWriter()
    writer.SetInputConnection(image.GetOutputPort())
    writer.SetFileName(path)
    writer.Write()


def main():
    path, x, y, z, kind, sx, sy, sz, isovalue = sys.argv[1:10]
    width, height = map(int, sys.argv[10:12])
    colour, background = map(rgb, sys.argv[12:14])
    angle, *places = map(float, sys.argv[14:24])
    plain, occluded = sys.argv[24:26]
    edges = flying_edges(raw_volume(path, (x, y, z), kind, (sx, sy, sz)))
    edges.SetValue(0, float(isovalue))
    mapper = vtkPolyDataMapper()
    mapper.SetInputConnection(edges.GetOutputPort())
    mapper.ScalarVisibilityOff()
    actor = vtkActor()
    actor.SetMapper(mapper)
    actor.GetProperty().SetColor(*colour)
    renderer = vtkRenderer()
    renderer.SetBackground(*background)
    renderer.AddActor(actor)
    camera = renderer.GetActiveCamera()
    camera.SetPosition(*places[0:3])
    camera.SetFocalPoint(*places[3:6])
    camera.SetViewUp(*places[6:9])
    camera.SetViewAngle(angle)
    renderer.ResetCameraClippingRange()
    window = vtkRenderWindow()
    window.SetOffScreenRendering(1)
    window.SetSize(width, height)
    window.SetMultiSamples(8)
    window.AddRenderer(renderer)
    save(window, plain)

    diagonal = sum((int(n) * float(s)) ** 2 for n, s in ((x, sx), (y, sy), (z, sz))) ** 0.5
    steps = vtkRenderStepsPass()
    occlusion = vtkSSAOPass()
    occlusion.SetRadius(0.1 * diagonal)
    occlusion.SetBias(0.001 * diagonal)
    occlusion.SetKernelSize(256)
    occlusion.BlurOn()
    occlusion.SetDelegatePass(steps)
    smooth = vtkSSAAPass()
    smooth.SetDelegatePass(occlusion)
    window.SetMultiSamples(0)
    renderer.SetPass(smooth)
    save(window, occluded)


main()
