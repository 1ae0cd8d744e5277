#include "gpu/opengl_module/gl_window.h"

#include <fmt/format.h>
#include <vtkLogger.h>
#include <vtkObjectFactory.h>
#include <vtkVersion.h>
#include <vtk_glew.h>

#include <stdexcept>
#include <utility>

#include "gpu/device.h"

namespace scanmill {

vtkStandardNewMacro(GlWindow);

void GlWindow::start(int width, int height) {
  SetReadyForRendering(true);
  SetIsCurrent(true);
  SetOwnContext(0);
  SetOffScreenRendering(1);
  SetMultiSamples(0);
  SetMapped(false);
  if (!InitializeFromCurrentContext()) throw NoDevice("VTK does not find OpenGL");
  SetSize(width, height);
}

// Loads OpenGL's functions, and hides the warning that there is no X display. Throws NoDevice without OpenGL 3.2.
void GlWindow::OpenGLInitContext() {
  if (Initialized) return;
  const int display = GetGlobalWarningDisplay();
  GlobalWarningDisplayOff();
  vtkGenericOpenGLRenderWindow::OpenGLInitContext();
  SetGlobalWarningDisplay(display);
  if (!GLEW_VERSION_3_2) throw NoDevice("VTK does not find OpenGL 3.2");
  Initialized = true;
  GlewInitValid = true;
  MaximumHardwareLineWidth = 1;
}

class Quiet::Messages : public vtkOutputWindow {
 public:
  static Messages* New();

  void DisplayText(const char*) override {}
  void DisplayErrorText(const char* text) override { errors_ += text; }
  void DisplayWarningText(const char*) override {}
  void DisplayGenericWarningText(const char*) override {}
  void DisplayDebugText(const char*) override {}

  std::string take() { return std::exchange(errors_, {}); }

 private:
  std::string errors_;
};

vtkStandardNewMacro(Quiet::Messages);

Quiet::Quiet() : before_(vtkOutputWindow::GetInstance()) {
  vtkLogger::SetStderrVerbosity(vtkLogger::VERBOSITY_OFF);  // `messages_` receives the messages instead
  vtkOutputWindow::SetInstance(messages_);
}

Quiet::~Quiet() {
  vtkOutputWindow::SetInstance(before_);
}

void Quiet::check() {
  if (const std::string errors = messages_->take(); !errors.empty()) throw std::runtime_error(errors);
}

std::string describeGl() {
  const auto* name = reinterpret_cast<const char*>(glGetString(GL_RENDERER));
  return fmt::format("VTK {}.{} on {}", vtkVersion::GetVTKMajorVersion(), vtkVersion::GetVTKMinorVersion(),
                     name != nullptr ? name : "an unknown device");
}

}  // namespace scanmill
