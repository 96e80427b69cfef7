// A plug-in that misbehaves as the environment's RUDE says; see plugin_test.cpp and bad_modes.py. It calls
// every pair apart by 1 m, which `rude_pair` turns into its own nonsense.
#include <fenv.h>
#include <locale.h>
#include <pthread.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#include <touchstone_plugin.h>

namespace {

int instance;

bool is(const char* how) {
  const char* const rude = getenv("RUDE");
  return rude != nullptr && strcmp(rude, how) == 0;
}

[[noreturn]] void wait_for_ever() {
  for (;;) pause();
}

volatile int deepest = 1 << 30;  // deeper than any stack

int overflow_stack(int depth) {
  if (depth > deepest) return 0;
  volatile char room[4096];
  room[0] = static_cast<char>(depth);
  return overflow_stack(depth + 1) + room[0];
}

void change_the_process() {
  if (is("rounding")) fesetround(FE_UPWARD);
  if (is("flush")) {
#ifdef __SSE2__
    __builtin_ia32_ldmxcsr(__builtin_ia32_stmxcsr() | 0x8040);
#endif
  }
  if (is("trap")) feenableexcept(FE_INEXACT);
  if (is("precision")) {
#ifdef __SSE2__
    unsigned short x87 = 0;
    __asm__ volatile("fnstcw %0" : "=m"(x87));
    x87 = static_cast<unsigned short>(x87 & ~0x300u);  // 24 bits
    __asm__ volatile("fldcw %0" : : "m"(x87));
#endif
  }
  if (is("chdir") && chdir("/") != 0) abort();
  if (is("locale")) setlocale(LC_ALL, "de_DE.UTF-8");
  if (is("signals"))
    for (int each = 1; each < 32; ++each) signal(each, SIG_IGN);
  if (is("umask")) umask(0777);
  if (is("descriptors"))
    for (int each = 0; each < 1024; ++each) close(each);
}

void go_wrong() {
  if (is("throw")) throw std::runtime_error("thrown");
  if (is("throw_number")) throw 7;
  if (is("end_thread")) pthread_exit(nullptr);
  if (is("print")) printf("a line that is none of the report's\n"), fflush(stdout);
  if (is("print_endlessly"))
    for (;;) fputs("and on and on\n", stderr);
  if (is("exit")) exit(0);
  if (is("exit_at_once")) _exit(0);
  if (is("abort")) abort();
  if (is("stack")) instance = overflow_stack(0);
  if (is("stop")) raise(SIGSTOP);
  if (is("hang")) wait_for_ever();
  if (is("spin"))
    for (;;) instance = instance + 1;
  if (is("nap")) usleep(700000);
  if (is("child") && fork() == 0) wait_for_ever();
  if (is("threads"))
    std::thread([] {
      for (;;) instance = instance + 1;
    }).detach();
  if (is("leak")) memset(malloc(1 << 20), 1, 1 << 20);
  change_the_process();
}

void rude_pair(size_t i, touchstone_status& status, touchstone_geometry& geometry) {
  static int calls = 0;
  if (is("changes") && ++calls % 2 == 0) geometry.separation = 2.0;
  if (is("negative_zero")) geometry.separation = -0.0;
  if (is("denormal")) geometry.separation = geometry.p_B_W[0] = std::numeric_limits<double>::denorm_min();
  if (is("huge")) geometry.separation = 1e300;
  if (is("infinity")) geometry.separation = std::numeric_limits<double>::infinity();
  if (is("nan_normal")) geometry.n_AB_W[1] = std::nan("");
  if (is("other_pair") && i == 3) status = TOUCHSTONE_OVERLAPPING;
  if (is("contradiction")) status = TOUCHSTONE_OVERLAPPING;
}

void* create() {
  if (is("throw_at_create")) throw std::runtime_error("thrown");
  return is("null") ? nullptr : &instance;
}
void destroy(void*) {
  if (is("throw_at_destroy")) throw std::runtime_error("thrown");
  if (is("crash_at_destroy")) raise(SIGSEGV);
}
int build(void*, const double*, size_t, char*, size_t) {
  if (is("throw_at_build")) throw std::runtime_error("thrown");
  return 0;
}
void* create_workspace(const void*) { return &instance; }
void destroy_workspace(void*) {
  if (is("hang_at_destroy")) wait_for_ever();
}

void evaluate(const void*, void*, const touchstone_input* in, const touchstone_output* out) {
  for (size_t i = 0; i < in->pair_count; ++i) {
    touchstone_geometry geometry = {1.0, {1, 0, 0}, {0, 0, 0}, {1, 0, 0}, 0, 0};
    touchstone_status status = TOUCHSTONE_SEPARATED;
    rude_pair(i, status, geometry);
    out->status[i] = status;
    if (in->query.kind != TOUCHSTONE_OVERLAP) out->geometry[i] = geometry;
  }
  if (is("overrun")) memset(static_cast<void*>(out->status + in->pair_count), 0x55, 1 << 16);
  if (is("fork")) fork();
  go_wrong();
}

__attribute__((constructor)) void load() {
  if (is("exit_at_load")) exit(0);
  if (is("throw_at_load")) throw std::runtime_error("thrown");
  if (is("crash_at_load")) raise(SIGSEGV);
  if (is("rounding_at_load")) fesetround(FE_UPWARD);
}
__attribute__((destructor)) void unload() {
  if (is("crash_at_unload")) raise(SIGSEGV);
  if (is("hang_at_unload")) wait_for_ever();
}

}  // namespace

extern "C" const touchstone_backend touchstone_plugin = {TOUCHSTONE_ABI_VERSION,
                                                         sizeof(touchstone_backend),
                                                         "rude",
                                                         "misbehaves",
                                                         {1, 1, 1, 1, 1, 1, {0, 0}, 64, 0, 0.0, 0.0, 0.0},
                                                         create,
                                                         destroy,
                                                         build,
                                                         create_workspace,
                                                         destroy_workspace,
                                                         evaluate};
