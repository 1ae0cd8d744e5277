#pragma once

// VTK on an OpenGL context that is not its own.

#include <vtkGenericOpenGLRenderWindow.h>
#include <vtkNew.h>
#include <vtkOutputWindow.h>
#include <vtkSmartPointer.h>

#include <string>

namespace scanmill {

// VTK needs a window to hold its state of OpenGL. This one shows nothing.
class GlWindow
    : public vtkGenericOpenGLRenderWindow {  // NOLINT(cppcoreguidelines-virtual-class-destructor): VTK counts
 public:
  static GlWindow* New();

  // Takes the context that is current, for pictures of this size (px). Throws NoDevice.
  void start(int width, int height);
  void OpenGLInitContext() override;
};

// While it lives, VTK's messages are kept, which otherwise would go to standard error.
class Quiet {
 public:
  Quiet();
  ~Quiet();
  Quiet(const Quiet&) = delete;
  Quiet& operator=(const Quiet&) = delete;

  // Throws std::runtime_error with the errors among them since the last call. The warnings are lost.
  void check();

 private:
  class Messages;

  vtkSmartPointer<vtkOutputWindow> before_;
  vtkNew<Messages> messages_;
};

// VTK's version, and what the current context draws with.
std::string describeGl();

}  // namespace scanmill
