// Preloaded into one program of a job, this kills it at a chosen moment, as kill -9 or the kernel
// would: BEDLOAD_KILL="PROGRAM RANK CALL WHAT". CALL is write, rename, remove, send, transform or
// allocate; WHAT is a part of the file's name, or the number of the call for send and transform.
// allocate: the first allocation after that many sends ends as where the heap is found spoilt, by
// SIGABRT with the lock held, for which any other allocation of the process waits.
// BEDLOAD_POISON="PROGRAM RANK transform NUMBER" makes the first number of that transform a NaN
// instead. BEDLOAD_KILLED: a file that is made right before, for the time of the fault.
#define _GNU_SOURCE
#include <dlfcn.h>
#include <errno.h>
#include <fcntl.h>
#include <math.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/uio.h>
#include <unistd.h>

static const char* wanted(const char* call) {
  static char program[64], rank[16], name[16], what[256];
  static int known = 0;
  if (!known) {
    const char* const killing = getenv("BEDLOAD_KILL");
    const char* const order = killing ? killing : getenv("BEDLOAD_POISON");
    const char* const mine = getenv("OMPI_COMM_WORLD_RANK");
    known = 1;
    if (!order || !mine || sscanf(order, "%63s %15s %15s %255s", program, rank, name, what) != 4 ||
        strcmp(program, program_invocation_short_name) != 0 || strcmp(rank, mine) != 0)
      name[0] = '\0';
  }
  return strcmp(name, call) == 0 ? what : NULL;
}

static void note(void) {
  const char* const mark = getenv("BEDLOAD_KILLED");
  if (mark) creat(mark, 0644);
}

static void die(void) {
  note();
  kill(getpid(), SIGKILL);
}

static void at_file(const char* call, const char* path) {
  const char* const what = wanted(call);
  if (what && strstr(path, what)) die();
}

static void at_descriptor(int file) {
  char link[64], path[4096];
  if (!wanted("write")) return;
  snprintf(link, sizeof link, "/proc/self/fd/%d", file);
  const ssize_t length = readlink(link, path, sizeof path - 1);
  if (length < 0) return;
  path[length] = '\0';
  at_file("write", path);
}

static void at_count(const char* call, double* numbers) {
  static long count = 0;
  const char* const what = wanted(call);
  if (!what || ++count != atol(what)) return;
  if (getenv("BEDLOAD_KILL"))
    die();
  else if (numbers)
    numbers[0] = NAN;
}

#define NEXT(function) \
  __typeof__(&function) next = (__typeof__(&function))dlsym(RTLD_NEXT, #function)

ssize_t write(int file, const void* bytes, size_t size) {
  NEXT(write);
  at_descriptor(file);
  return next(file, bytes, size);
}
ssize_t pwrite(int file, const void* bytes, size_t size, off_t place) {
  NEXT(pwrite);
  at_descriptor(file);
  return next(file, bytes, size, place);
}
ssize_t pwrite64(int file, const void* bytes, size_t size, off64_t place) {
  NEXT(pwrite64);
  at_descriptor(file);
  return next(file, bytes, size, place);
}
ssize_t writev(int file, const struct iovec* parts, int count) {
  NEXT(writev);
  at_descriptor(file);
  return next(file, parts, count);
}
int rename(const char* from, const char* to) {
  NEXT(rename);
  at_file("rename", to);
  return next(from, to);
}
int unlink(const char* path) {
  NEXT(unlink);
  at_file("remove", path);
  return next(path);
}
int remove(const char* path) {
  NEXT(remove);
  at_file("remove", path);
  return next(path);
}
static long sends = 0;
int MPI_Isend(const void* buffer, int count, void* type, int to, int tag, void* comm,
              void* request) {
  NEXT(MPI_Isend);
  ++sends;
  at_count("send", NULL);
  return next(buffer, count, type, to, tag, comm, request);
}
void fftw_execute_dft(const void* plan, void* in, void* out) {
  NEXT(fftw_execute_dft);
  at_count("transform", in);
  next(plan, in, out);
}
void fftw_execute_dft_r2c(const void* plan, double* in, void* out) {
  NEXT(fftw_execute_dft_r2c);
  at_count("transform", in);
  next(plan, in, out);
}

void* __libc_malloc(size_t size);
void* malloc(size_t size) {
  static volatile sig_atomic_t is_locked = 0;
  while (is_locked) pause();
  const char* const after = wanted("allocate");
  if (after && sends >= atol(after)) {
    note();
    is_locked = 1;
    raise(SIGABRT);
  }
  return __libc_malloc(size);
}
