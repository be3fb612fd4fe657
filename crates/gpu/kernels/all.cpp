// All kernels, as one text for the compiler.
#include "platform.h"
#include "scan.h"
#include "sort.h"
#include "rows.h"
#include "laws.h"
#include "step.h"
