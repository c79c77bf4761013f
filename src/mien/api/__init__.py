"""What `import mien` offers: the calls most people need, and what is made of many or changed lines."""
