"""The paper's timing tables run again (Tables 2, 4, 6, 8), growth, targets and other codes."""
