#pragma once

// Lets VTK use an OpenGL context that the program has created itself.

#include <vtkGenericOpenGLRenderWindow.h>
#include <vtkNew.h>
#include <vtkOutputWindow.h>
#include <vtkSmartPointer.h>

#include <string>

namespace scanmill {

// An invisible window. VTK stores its OpenGL state in a window, even if nothing is shown.
class GlWindow
    : public vtkGenericOpenGLRenderWindow {  // NOLINT(cppcoreguidelines-virtual-class-destructor): VTK counts
 public:
  static GlWindow* New();

  // Lets VTK render images of this size (pixels) with the current context. Throws NoDevice if VTK finds no OpenGL.
  void start(int width, int height);
  void OpenGLInitContext() override;
};

// Collects VTK's messages as long as this object exists; VTK would print them to standard error.
class [[nodiscard]] Quiet {
 public:
  Quiet();
  ~Quiet();
  Quiet& operator=(Quiet&&) = delete;  // neither copied nor moved

  // Throws std::runtime_error with the error messages since the last call, if there are any. Warnings are discarded.
  void check();

 private:
  class Messages;

  vtkSmartPointer<vtkOutputWindow> before_;
  vtkNew<Messages> messages_;
};

// Returns a text with VTK's version and the name of the current context's device.
std::string describeGl();

}  // namespace scanmill
