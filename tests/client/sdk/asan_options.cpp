// Debian's c-ares, which gRPC resolves names with, keeps a few bytes of each lookup.
#ifdef __SANITIZE_ADDRESS__

extern "C" const char* __lsan_default_suppressions() { return "leak:libcares.so\n"; }

#endif
