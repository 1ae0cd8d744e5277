// Libraries stay loaded to the end in programs that are built for the address sanitizer. It tells what is lost when a
// program ends, and what only a library that is gone points to counts as lost: 240 bytes of Mesa's driver, which EGL
// unloads with the last window. Of such a library lsan.supp cannot name what it asked for: its module is unknown then.
// Of all that defines dlclose() the program comes first.

extern "C" int dlclose(void*) {
  return 0;
}
