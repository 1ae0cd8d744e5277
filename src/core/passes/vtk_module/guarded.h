#pragma once

// The way into the module: on the thread of all OpenGL, and out again without exceptions.

#include <algorithm>
#include <exception>
#include <new>
#include <string_view>

#include "passes/vtk/vtk_module.h"
#include "passes/vtk_module/egl_context.h"
#include "passes/vtk_module/gl_thread.h"

namespace scanmill {

inline void put(ScanmillVtkText& to, std::string_view text) {
  const std::size_t size = std::min(text.size(), sizeof to.text - 1);
  std::copy_n(text.data(), size, to.text);
  to.text[size] = '\0';
}

// Runs `work` on the thread of all OpenGL, and lets no exception out.
template <class Work>
ScanmillVtkStatus guarded(GlThread& thread, ScanmillVtkText& error, const Work& work) noexcept {
  try {
    thread.run(work);
    put(error, "");
    return kScanmillVtkDone;
  } catch (const std::bad_alloc&) {
    put(error, "out of memory");
    return kScanmillVtkOutOfMemory;
  } catch (const NoDevice& e) {
    put(error, e.what());
    return kScanmillVtkNoDevice;
  } catch (const std::exception& e) {
    put(error, e.what());
  } catch (...) {
    put(error, "");
  }
  return kScanmillVtkFailed;
}

}  // namespace scanmill
