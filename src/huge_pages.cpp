// Replaces the program's operator new: meshes, their planes and other large arrays use huge pages if the kernel gives
// them on request (`madvise` in /sys/kernel/mm/transparent_hugepage/enabled). Mapping small pages one by one took two
// fifths of the set-up of a million triangles. Smaller allocations, and other programs that use the library, keep the
// default allocator.

#include <sys/mman.h>

#include <cstddef>
#include <cstdlib>
#include <new>

namespace {

constexpr std::size_t kHugePage = std::size_t{2} << 20;
constexpr std::size_t kLarge = 2 * kHugePage;  // bytes; from this size on, the last page's waste does not matter

void* allocate(std::size_t bytes) {
  if (bytes < kLarge) return std::malloc(bytes == 0 ? 1 : bytes);
  void* memory = std::aligned_alloc(kHugePage, bytes);
  if (memory != nullptr) ::madvise(memory, bytes, MADV_HUGEPAGE);  // only a hint: without it, small pages are used
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
