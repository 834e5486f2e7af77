def restore(root, words): raise NotImplementedError
