// All kernels, for the processor.
#include "platform.h"
#include "scan.h"
#include "sort.h"
#include "rows.h"
#include "pairs.h"
#include "lists.h"
#include "extremes.h"
#include "sums.h"
#include "laws.h"
#include "joints.h"
#include "watch.h"
#include "patch.h"
#include "contact.h"
#include "step.h"

// Several builds are linked into one program, so the name begins with that of the build.
#define JOINED(build, name) build##_##name
#define NAME(build, name) JOINED(build, name)

// The kernel with a name; null if there is none.
extern "C" HostKernel NAME(BUILD, kernel)(const char *name) {
    for (const Entry *entry = first_entry; entry; entry = entry->next) {
        if (strcmp(entry->name, name) == 0) return entry->kernel;
    }
    return nullptr;
}
