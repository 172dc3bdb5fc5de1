// Notes, by LD_PRELOAD, how many bytes a program has taken from the C library and not given back: a
// number every 2 ms, line by line, in the file BEDLOAD_HEAP.
#include <malloc.h>
#include <pthread.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <unistd.h>

static void* note(void* file) {
  for (;;) {
    const struct mallinfo2 heap = mallinfo2();
    fprintf(file, "%zu\n", heap.uordblks + heap.hblkhd);
    fflush(file);
    usleep(2000);
  }
  return NULL;
}

__attribute__((constructor)) static void begin(void) {
  const char* name = getenv("BEDLOAD_HEAP");
  FILE* file = name ? fopen(name, "w") : NULL;
  unsetenv("BEDLOAD_HEAP");  // of this program alone, not of those that it starts
  if (!file) return;
  // The program's signals are for its own thread.
  sigset_t all, before;
  sigfillset(&all);
  pthread_sigmask(SIG_SETMASK, &all, &before);
  pthread_t thread;
  if (pthread_create(&thread, NULL, note, file) == 0) pthread_detach(thread);
  pthread_sigmask(SIG_SETMASK, &before, NULL);
}
