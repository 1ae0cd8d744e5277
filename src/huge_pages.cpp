// The program's own operator new: meshes, their planes and other large arrays lie on huge pages, where the kernel gives
// them to who asks (`madvise` in /sys/kernel/mm/transparent_hugepage/enabled). Handing out small pages one by one took
// two fifths of the set-up of a million triangles. Everything else, and programs of others that use the library, have
// the allocator that they have.

#include <sys/mman.h>

#include <cstddef>
#include <cstdlib>
#include <new>

namespace {

constexpr std::size_t kHugePage = std::size_t{2} << 20;
constexpr std::size_t kLarge = 2 * kHugePage;  // whose last page, half empty, does not count

void* allocate(std::size_t bytes) {
  if (bytes < kLarge) return std::malloc(bytes == 0 ? 1 : bytes);
  void* memory = std::aligned_alloc(kHugePage, bytes);
  if (memory != nullptr) ::madvise(memory, bytes, MADV_HUGEPAGE);  // a wish: without it all is as before
  return memory;
}

}  // namespace

void* operator new(std::size_t bytes) {
  for (;;) {
    if (void* memory = allocate(bytes)) return memory;
    const std::new_handler makeRoom = std::get_new_handler();
    if (makeRoom == nullptr) throw std::bad_alloc();
    makeRoom();
  }
}

void operator delete(void* memory) noexcept {
  std::free(memory);
}

void operator delete(void* memory, std::size_t) noexcept {
  std::free(memory);
}
