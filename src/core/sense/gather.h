#pragma once

// The last stage of sensing: rows of the table of returns become points of a scan.

#include "scan/hits.h"
#include "scan/scan.h"
#include "sense/returns.h"
#include "sense/thing_motions.h"
#include "sensors/shot.h"

namespace scanmill {

// Keeps the columns of the layout; an intensity only where an effect has set it. Dense scans are ordered by column,
// then ring, then return: the order of firing. Of a beam's returns the nearest is the first. `motions`: of a scene that
// moves, else null.
void gather(const Hits& hits, const Shot& shot, const Returns& returns, const ScanLayout& layout,
            const ThingMotions* motions, Scan& scan);

}  // namespace scanmill
