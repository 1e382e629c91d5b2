/* Which faults act, and which are reached (switching.py). TESSERA_FAULTS: numbers with commas between. TESSERA_FAULTS_REACHED:
   a file of a byte for each number, which becomes 1. */
#include <fcntl.h>
#include <stdlib.h>
#include <sys/mman.h>
#include <unistd.h>

enum { most = 4096 };
static unsigned char acts[most], unread[most], *reached = unread;

__attribute__((constructor(101))) static void prepare(void)
{
    char *text = getenv("TESSERA_FAULTS"), *file = getenv("TESSERA_FAULTS_REACHED");
    while (text && *text) {
        const long number = strtol(text, &text, 10);
        if (number >= 0 && number < most)
            acts[number] = 1;
        if (*text)
            ++text;
    }
    const int open_ = file ? open(file, O_RDWR) : -1;
    void *const map = open_ < 0 ? MAP_FAILED : mmap(0, most, PROT_READ | PROT_WRITE, MAP_SHARED, open_, 0);
    if (map != MAP_FAILED)
        reached = map;
    if (open_ >= 0)
        close(open_);
}

_Bool tesseraFault(int number)
{
    if (!reached[number])
        reached[number] = 1;
    return acts[number];
}
