// The kernel is compiled several times, once per instruction set. Every copy lives in a namespace
// of its own, named by SANSO_ISA, so that the linker can never replace a portable function by one
// with instructions the machine lacks.
// For the same reason kernel headers use no templates and no inline functions from outside this
// folder.
#pragma once

#ifndef SANSO_ISA
#define SANSO_ISA portable
#endif
