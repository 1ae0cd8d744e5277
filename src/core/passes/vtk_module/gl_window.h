#pragma once

// VTK on an OpenGL context that is not its own.

#include <vtkGenericOpenGLRenderWindow.h>
#include <vtkNew.h>
#include <vtkOutputWindow.h>
#include <vtkSmartPointer.h>

#include <string>

namespace scanmill {

// A window that is none: VTK needs one to hold its state of OpenGL.
class GlWindow
    : public vtkGenericOpenGLRenderWindow {  // NOLINT(cppcoreguidelines-virtual-class-destructor): VTK counts
 public:
  static GlWindow* New();

  // Takes the context that is current. Throws NoDevice.
  void start(int width, int height);
  void OpenGLInitContext() override;
};

// While it lives, VTK's messages are kept; else they would go to standard error.
class Quiet {
 public:
  Quiet();
  ~Quiet();
  Quiet(const Quiet&) = delete;
  Quiet& operator=(const Quiet&) = delete;

  // Takes the errors among them. The warnings are lost.
  std::string errors();

 private:
  class Messages;

  vtkSmartPointer<vtkOutputWindow> before_;
  vtkNew<Messages> messages_;
};

// VTK's version, and what the current context draws with.
std::string describeGl();

}  // namespace scanmill
