#pragma once

// A camera as attributes of an EXR file: see pass_exr.h for their names.

#include "passes/camera.h"
#include "passes/exr/exr_file.h"

namespace scanmill {

ExrAttributes cameraAttributes(const Camera& camera);

// Returns the camera of a file's image. Throws InputError that names the file and the attribute.
Camera readCamera(const ExrReader& file);

}  // namespace scanmill
