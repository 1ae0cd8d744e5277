#pragma once

// Lets VTK use an OpenGL context that it has not created.

#include <vtkGenericOpenGLRenderWindow.h>
#include <vtkNew.h>
#include <vtkOutputWindow.h>
#include <vtkSmartPointer.h>

#include <string>

namespace scanmill {

// VTK needs a window that stores its OpenGL state. This one shows nothing.
class GlWindow
    : public vtkGenericOpenGLRenderWindow {  // NOLINT(cppcoreguidelines-virtual-class-destructor): VTK counts
 public:
  static GlWindow* New();

  // Uses the current context, for images of this size (px). Throws NoDevice.
  void start(int width, int height);
  void OpenGLInitContext() override;
};

// Collects VTK's messages while it lives; otherwise they would go to standard error.
class Quiet {
 public:
  Quiet();
  ~Quiet();
  Quiet(const Quiet&) = delete;
  Quiet& operator=(const Quiet&) = delete;

  // Throws std::runtime_error with the errors since the last call, if there are any. Warnings are discarded.
  void check();

 private:
  class Messages;

  vtkSmartPointer<vtkOutputWindow> before_;
  vtkNew<Messages> messages_;
};

// Returns VTK's version and the current context's device.
std::string describeGl();

}  // namespace scanmill
