"""The way of a line, step by step: inputs, speak, translate, perform. Read `perform` first."""
