#include "tests/precompiled_headers.h"
