"""From a traced program to machine code that runs several simulations side by side in the lanes of vector registers."""
